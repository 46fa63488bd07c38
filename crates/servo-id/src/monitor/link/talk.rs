//! The conversation with the drive, in the line's thread.

use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::{Duration, Instant};

use drive_link::{Command, Refusal, Report, Request};

use super::event::{Ending, LinkError, LinkEvent};
use crate::drive::{AtEnd, DriveError, Driven, Silence, is_driven};
use crate::port::STOP_INTERVAL;

/// Longest wait of a command.
const MAX_COMMAND_WAIT: Duration = Duration::from_millis(5);

/// Time after which an unanswered command is sent again, and after which it is given up.
const REPEAT_AFTER: Duration = Duration::from_millis(200);
const GIVE_UP_AFTER: Duration = Duration::from_secs(5);

/// The conversation with a drive.
pub(super) struct Talk {
    drive: Driven,
    events: Sender<LinkEvent>,
    unanswered: Vec<Unanswered>,
    silence: Silence,
    /// The servo is driven, by the last report.
    drives: bool,
}

/// A command that is not answered yet.
struct Unanswered {
    id: u8,
    command: Command,
    first: Instant,
    last: Instant,
}

impl Talk {
    pub(super) fn new(drive: Driven, events: Sender<LinkEvent>) -> Self {
        Self {
            drive,
            events,
            unanswered: Vec::new(),
            silence: Silence::begin(),
            drives: false,
        }
    }

    /// Runs until the commands end.
    pub(super) fn run(&mut self, orders: &Receiver<Command>) -> Result<(), LinkError> {
        loop {
            match orders.try_recv() {
                Ok(command) => self.send(command)?,
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => return Ok(()),
            }
            self.repeat_unanswered()?;
            match self
                .drive
                .next_within(MAX_COMMAND_WAIT, |report| Some(report.clone()))?
            {
                Some(report) => {
                    self.silence.end();
                    self.take(report)?;
                }
                None if self.silence.is_too_long() => return Err(LinkError::Silent),
                None => {}
            }
        }
    }

    fn send(&mut self, command: Command) -> Result<(), DriveError> {
        // A motion that is pending belongs to the run before.
        if matches!(
            command,
            Command::Stop | Command::Start | Command::Commission(_)
        ) {
            self.forget_motions();
        }
        let id = self.drive.send(command)?;
        let now = Instant::now();
        self.unanswered.push(Unanswered {
            id,
            command,
            first: now,
            last: now,
        });
        Ok(())
    }

    fn repeat_unanswered(&mut self) -> Result<(), DriveError> {
        let mut silent = Vec::new();
        self.unanswered.retain(|asked| {
            let waits = asked.first.elapsed() < GIVE_UP_AFTER;
            if !waits {
                silent.push(asked.command);
            }
            waits
        });
        for command in silent {
            self.report_event(LinkEvent::Unanswered(command));
        }
        for asked in &mut self.unanswered {
            // Sent twice, these could be done twice: once now, and once after they have ended.
            let once = matches!(asked.command, Command::Start | Command::Commission(_));
            let interval = match asked.command {
                Command::Stop => STOP_INTERVAL,
                _ => REPEAT_AFTER,
            };
            if !once && asked.last.elapsed() >= interval {
                asked.last = Instant::now();
                let (id, command) = (asked.id, asked.command);
                self.drive.port().send(&Request { id, command })?;
            }
        }
        Ok(())
    }

    /// What is pending belongs to a run and ends with it: nobody has ordered it of the next run.
    fn forget_motions(&mut self) {
        self.unanswered.retain(|asked| !asked.command.may_move());
    }

    fn take(&mut self, report: Report) -> Result<(), DriveError> {
        let drove = self.drives;
        match &report {
            Report::Status { status, .. } => self.drives = is_driven(status.state),
            Report::Snapshot(_) | Report::Progress(_) => self.drives = true,
            Report::Fault(_) => self.drives = false,
            _ => {}
        }
        if drove && !self.drives {
            self.forget_motions();
        }
        match report {
            Report::Done { id } => {
                if let Some(command) = self.was_asked(id) {
                    self.report_event(LinkEvent::Done(command));
                }
            }
            Report::Refused { id, refusal } => {
                match (self.was_asked(id), refusal) {
                    // Another program had this number. What acts once is sent once.
                    (Some(command), Refusal::DoneBefore) => self.send(command)?,
                    (Some(_), refusal) => self.report_event(LinkEvent::Refused(refusal)),
                    (None, _) => {}
                }
            }
            report => {
                if let Report::Settings { id, .. } = report {
                    self.was_asked(id);
                }
                self.report_event(LinkEvent::Report(report));
            }
        }
        Ok(())
    }

    /// The command of an answer. One that was sent again may be answered twice.
    fn was_asked(&mut self, id: u8) -> Option<Command> {
        let place = self.unanswered.iter().position(|asked| asked.id == id)?;
        Some(self.unanswered.remove(place).command)
    }

    fn report_event(&self, event: LinkEvent) {
        // A session that ends closes the commands, too.
        let _ = self.events.send(event);
    }

    pub(super) fn end(&mut self, at_end: AtEnd) -> Result<Ending, LinkError> {
        let ending = match at_end {
            AtEnd::Stop => {
                // Whatever it does: nothing comes before a stop.
                self.drive.stop()?;
                if self.drives {
                    Ending::Stopped
                } else {
                    Ending::WasDisabled
                }
            }
            AtEnd::Leave if is_driven(self.drive.status()?.state) => Ending::Left,
            AtEnd::Leave => Ending::WasDisabled,
        };
        self.drive.watch(0)?;
        Ok(ending)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use drive_link::Fault;

    use super::*;
    use crate::drive::Client;
    use crate::scripted_line::{self, Received};

    /// A conversation whose drive answers nothing.
    fn unanswered() -> (Talk, Received) {
        let (port, received) = scripted_line::port(|_| None);
        let drive = Driven::new(Client::new(port), 1.0, AtEnd::Leave);
        (Talk::new(drive, mpsc::channel().0), received)
    }

    /// The times that a command is sent again after a while.
    fn repeated(talk: &mut Talk, received: &Received, command: Command) -> usize {
        let before = received.count(command);
        for asked in &mut talk.unanswered {
            asked.last -= REPEAT_AFTER;
        }
        talk.repeat_unanswered().expect("the line is whole");
        received.count(command) - before
    }

    #[test]
    fn a_number_of_another_program_is_given_up() {
        let (mut talk, received) = unanswered();
        for command in [Command::Start, Command::Stop] {
            talk.send(command).expect("the line is whole");
            let id = talk.unanswered.last().expect("it is asked").id;
            let refusal = match command {
                Command::Start => Refusal::DoneBefore,
                _ => Refusal::NotConfigured,
            };
            for _ in 0..2 {
                // The second is of nothing that waits.
                let refusal = refusal.clone();
                talk.take(Report::Refused { id, refusal })
                    .expect("the line is whole");
            }
        }
        assert_eq!(received.count(Command::Start), 2);
        assert_eq!(received.count(Command::Stop), 1);
    }

    #[test]
    fn a_motion_that_is_pending_ends_with_its_run() {
        const TARGET: Command = Command::Target(0.5);
        type End = fn(&mut Talk) -> Result<(), DriveError>;
        let ends: [End; 4] = [
            |talk| talk.send(Command::Stop),
            // It was sent before there was a run.
            |_| Ok(()),
            |talk| {
                talk.drives = true;
                talk.take(Report::Fault(Fault::LinkLost))
            },
            |talk| {
                talk.send(Command::Stop)?;
                talk.send(Command::Clear)
            },
        ];
        for end in ends {
            let (mut talk, received) = unanswered();
            for motion in [TARGET, Command::Home] {
                talk.send(motion).expect("the line is whole");
                assert_eq!(repeated(&mut talk, &received, motion), 1);
            }
            end(&mut talk).expect("the line is whole");
            talk.send(Command::Start).expect("the line is whole");
            for motion in [TARGET, Command::Home, Command::Start] {
                assert_eq!(repeated(&mut talk, &received, motion), 0, "{motion:?}");
            }
            // What is ordered in the new run is sent until it is answered.
            talk.send(TARGET).expect("the line is whole");
            assert_eq!(repeated(&mut talk, &received, TARGET), 1);
        }
    }

    #[test]
    fn a_stop_is_repeated_sooner_than_anything_else_and_under_its_number() {
        let (mut talk, received) = unanswered();
        for command in [Command::Stop, Command::Save] {
            talk.send(command).expect("the line is whole");
        }
        for asked in &mut talk.unanswered {
            asked.last = Instant::now() - STOP_INTERVAL;
        }
        talk.repeat_unanswered().expect("the line is whole");
        let all = received.all();
        assert_eq!(
            received.commands(),
            [Command::Stop, Command::Save, Command::Stop]
        );
        assert_eq!(all[0].id, all[2].id);
    }
}
