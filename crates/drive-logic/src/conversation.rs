//! The background's turns: requests first, then reports while the line has room, then work.

use drive_link::{FrameError, Line, MAX_FRAME_BYTES, PROTOCOL, Receiver, Refusal, Report};
use embedded_storage::nor_flash::NorFlash;

use crate::supervisor::Supervisor;

/// The loop of the background.
///
/// Stops are heard by the line's listener, whatever waits before them. Reports never take the room that an answer
/// needs. A request is carried out whether or not there is room for its answer. A host without an answer repeats the
/// request with its numbers, by which an order acts once.
#[derive(Debug, Default)]
pub struct Conversation {
    receiver: Receiver,
    /// A report of the state that waits for room.
    pending: Option<Report>,
}

/// Bytes that one turn decodes: those of 1.6 ms at 1 Mbaud.
const BYTES_PER_TURN: usize = 160;

impl Conversation {
    /// Waits for the beginning of a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
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
        line.listen();
        let answered = self.answer(line, supervisor);
        let reported = self.report(line, supervisor);
        let works = supervisor.work();
        answered || reported || works
    }

    /// Decodes bytes until one request was answered.
    #[inline(never)]
    fn answer<F: NorFlash>(
        &mut self,
        line: &mut impl Line,
        supervisor: &mut Supervisor<'_, F>,
    ) -> bool {
        for _ in 0..BYTES_PER_TURN {
            // Before the byte is looked for: where there is none, all of this lies in bytes that were decoded.
            let heard = supervisor.heard();
            let Some(byte) = line.receive() else {
                supervisor.set_decoded(heard);
                return false;
            };
            match &self.receiver.take_request(byte) {
                Some(Ok(request)) => {
                    let done = supervisor.obey(request, || line.listen());
                    answer_with(line, || supervisor.answer_to(request, done));
                    return true;
                }
                &Some(Err(FrameError::NoRequest { id, given, bytes })) => {
                    let refusal = Refusal::NotUnderstood {
                        spoken: PROTOCOL,
                        given,
                        bytes,
                    };
                    answer_with(line, || Report::Refused { id, refusal });
                    return true;
                }
                Some(Err(_)) => supervisor.count_garbled(),
                None => {}
            }
        }
        true
    }

    /// Sends one report.
    #[inline(never)]
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

/// Sends an answer. On its own: its stack is no part of what a request is obeyed by.
#[inline(never)]
fn answer_with(line: &mut impl Line, answer: impl FnOnce() -> Report) {
    send(line, &answer(), 0);
}

/// Sends a report, if there is room for it and for a reserve, bytes.
fn send(line: &mut impl Line, report: &Report, reserve: usize) -> bool {
    if line.room() < reserve {
        return false;
    }
    let Ok(framed) = report.framed() else {
        return false;
    };
    let has_room = line.room() >= framed.len() + reserve;
    if has_room {
        line.send(&framed);
    }
    has_room
}
