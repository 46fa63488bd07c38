//! The background's turns: stops first, then requests, then reports while the line has room, then work.

use drive_link::{
    Command, Line, MAX_FRAME_BYTES, Receiver, Refusal, Report, Request, StopListener, frame,
};
use embedded_storage::nor_flash::NorFlash;
use heapless::Deque;

use crate::supervisor::Supervisor;

/// The loop of the background.
///
/// A stop is obeyed as soon as its last byte has come, whatever waits before it. Requests come next, and reports never
/// take the room that an answer needs. A request is carried out whether or not there is room for its answer: a host that
/// gets none repeats the request, which does no harm.
#[derive(Debug, Default)]
pub struct Conversation {
    stops: StopListener,
    /// Bytes that were not decoded yet but for stops.
    waiting: Deque<u8, WAITING>,
    /// Stops among the waiting bytes: obeyed already, to be answered still.
    stops_waiting: u32,
    receiver: Receiver,
    /// A report of the state that waits for room.
    pending: Option<Report>,
}

/// Bytes that may wait: two of the longest frames, and a power of two.
const WAITING: usize = 2048;
const _: () = assert!(WAITING > 2 * MAX_FRAME_BYTES);

/// Bytes that one turn decodes: those of 1.6 ms at 1 Mbaud.
const BYTES_PER_TURN: usize = 160;

impl Conversation {
    /// Waits for the beginning of a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            stops: StopListener::new(),
            waiting: Deque::new(),
            stops_waiting: 0,
            receiver: Receiver::new(),
            pending: None,
        }
    }

    /// One turn; true if there may be more to do at once.
    pub fn turn<F: NorFlash>(
        &mut self,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> bool {
        supervisor.count_turn();
        self.receive(line, supervisor);
        let answered = self.answer(line, supervisor);
        let reported = self.report(line, supervisor);
        let works = supervisor.work();
        answered || reported || works
    }

    /// Takes in the bytes of the line, and obeys the stops in them.
    fn receive<F: NorFlash>(&mut self, line: &mut impl Line, supervisor: &Supervisor<'_, F>) {
        while let Some(byte) = line.receive() {
            // One that finds no room is lost, which spoils its frame; but no stop.
            let _ = self.waiting.push_back(byte);
            if self.stops.take(byte) {
                supervisor.stop();
                self.stops_waiting = self.stops_waiting.saturating_add(1);
            }
        }
    }

    /// Decodes bytes until one request was answered.
    fn answer<F: NorFlash>(
        &mut self,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> bool {
        for _ in 0..BYTES_PER_TURN {
            let Some(byte) = self.waiting.pop_front() else {
                self.stops_waiting = 0;
                return false;
            };
            match self.receiver.take::<Request>(byte) {
                Some(Ok(request)) => {
                    let answer = self.carried_out(&request, line, supervisor);
                    send(line, &answer, 0);
                    return true;
                }
                Some(Err(_)) => supervisor.count_garbled(),
                None => {}
            }
        }
        true
    }

    /// Carries a request out, unless a stop came after it that was obeyed already.
    fn carried_out<F: NorFlash>(
        &mut self,
        request: &Request,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> Report {
        let refused = Report::Refused {
            id: request.id,
            refusal: Refusal::Overtaken,
        };
        match request.command {
            Command::Stop => self.stops_waiting = self.stops_waiting.saturating_sub(1),
            Command::Start | Command::Target(_) | Command::Commission(_)
                if self.stops_waiting > 0 =>
            {
                return refused;
            }
            _ => {}
        }
        supervisor.answer_unless(request, |supervisor| {
            self.receive(line, supervisor);
            self.stops_waiting > 0
        })
    }

    /// Sends one report.
    fn report<F: NorFlash>(
        &mut self,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> bool {
        if let Some(report) = &self.pending
            && send(line, report, MAX_FRAME_BYTES)
        {
            self.pending = None;
        }
        let Some(report) = supervisor.next_report() else {
            return false;
        };
        let sent = self.pending.is_none() && send(line, &report, MAX_FRAME_BYTES);
        if !sent {
            match report {
                Report::Snapshot(_) | Report::Progress(_) => supervisor.count_dropped(),
                // Only the newest state counts.
                _ => self.pending = Some(report),
            }
        }
        true
    }
}

/// Sends a report, if there is room for it and for a reserve, bytes.
fn send(line: &mut impl Line, report: &Report, reserve: usize) -> bool {
    if line.room() < reserve {
        return false;
    }
    let Ok(framed) = frame(report) else {
        return false;
    };
    let has_room = line.room() >= framed.len() + reserve;
    if has_room {
        line.send(&framed);
    }
    has_room
}
