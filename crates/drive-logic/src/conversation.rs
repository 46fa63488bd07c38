//! The background's turns: stops first, then requests, then news as far as the line has room, then work.

use drive_link::{
    Command, LONGEST_FRAME, Line, Receiver, Refusal, Report, Request, StopListener, frame,
};
use embedded_storage::nor_flash::NorFlash;
use heapless::Deque;

use crate::supervisor::Supervisor;

/// What the background of a drive does over and over.
///
/// A stop is obeyed as soon as its last byte has come, whatever waits before it. Requests come next,
/// and news never take the room that an answer needs. A request is carried out whether or not there is
/// room for its answer: who does not hear one asks again, which does no harm.
#[derive(Debug, Default)]
pub struct Conversation {
    stops: StopListener,
    /// What came and was not looked at yet but for stops.
    waiting: Deque<u8, WAITING>,
    /// Stops among the waiting bytes: obeyed already, to be answered still.
    stops_waiting: u32,
    receiver: Receiver,
    /// News that must not be lost, waiting for room.
    must_say: Option<Report>,
}

/// Bytes that may wait: two of the longest frames, and a power of two.
const WAITING: usize = 2048;
const _: () = assert!(WAITING > 2 * LONGEST_FRAME);

/// Bytes that one turn looks at: as many as come in 1.6 ms at 1 Mbaud.
const LOOK_AT: usize = 160;

impl Conversation {
    /// Waits for the beginning of a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            stops: StopListener::new(),
            waiting: Deque::new(),
            stops_waiting: 0,
            receiver: Receiver::new(),
            must_say: None,
        }
    }

    /// One turn; true if there may be more to do at once.
    pub fn turn<F: NorFlash>(
        &mut self,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> bool {
        supervisor.is_alive();
        self.listen(line, supervisor);
        let answered = self.answer(line, supervisor);
        let told = self.tell(line, supervisor);
        let works = supervisor.work();
        answered || told || works
    }

    /// Takes in what came, and obeys the stops in it.
    fn listen<F: NorFlash>(&mut self, line: &mut impl Line, supervisor: &Supervisor<'_, F>) {
        while let Some(byte) = line.hear() {
            // One that finds no room is lost, which spoils its frame; but no stop.
            let _ = self.waiting.push_back(byte);
            if self.stops.take(byte) {
                supervisor.stop();
                self.stops_waiting = self.stops_waiting.saturating_add(1);
            }
        }
    }

    /// Looks at what waits until one request was answered.
    fn answer<F: NorFlash>(
        &mut self,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> bool {
        for _ in 0..LOOK_AT {
            let Some(byte) = self.waiting.pop_front() else {
                self.stops_waiting = 0;
                return false;
            };
            match self.receiver.take::<Request>(byte) {
                Some(Ok(request)) => {
                    let answer = self.done(&request, line, supervisor);
                    say(line, &answer, 0);
                    return true;
                }
                Some(Err(_)) => supervisor.garbled(),
                None => {}
            }
        }
        true
    }

    /// Does what is asked for, unless a stop came after it that was obeyed already.
    fn done<F: NorFlash>(
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
            self.listen(line, supervisor);
            self.stops_waiting > 0
        })
    }

    /// Says one piece of news.
    fn tell<F: NorFlash>(
        &mut self,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> bool {
        if let Some(report) = &self.must_say
            && say(line, report, LONGEST_FRAME)
        {
            self.must_say = None;
        }
        let Some(report) = supervisor.news() else {
            return false;
        };
        let said = self.must_say.is_none() && say(line, &report, LONGEST_FRAME);
        if !said {
            match report {
                Report::Snapshot(_) | Report::Progress(_) => supervisor.unsaid(),
                // The newest says how things stand now.
                _ => self.must_say = Some(report),
            }
        }
        true
    }
}

/// Says a report, if there is room for it and for so many bytes more.
fn say(line: &mut impl Line, report: &Report, reserve: usize) -> bool {
    if line.room() < reserve {
        return false;
    }
    let Ok(framed) = frame(report) else {
        return false;
    };
    let has_room = line.room() >= framed.len() + reserve;
    if has_room {
        line.say(&framed);
    }
    has_room
}
