//! The conversation with the drive, in the line's thread.

use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::{Duration, Instant};

use drive_link::{Command, Report, State};

use super::event::{AtEnd, Ending, LinkError, LinkEvent};
use crate::drive::{Client, DriveError, Silence};

/// Longest wait of a command.
const MAX_COMMAND_WAIT: Duration = Duration::from_millis(5);

/// Time after which an unanswered command is sent again, and after which it is given up.
const REPEAT_AFTER: Duration = Duration::from_millis(200);
const GIVE_UP_AFTER: Duration = Duration::from_secs(5);

/// The conversation with a drive.
pub(super) struct Talk {
    client: Client,
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
    pub(super) fn new(client: Client, events: Sender<LinkEvent>) -> Self {
        Self {
            client,
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
                .client
                .next_within(MAX_COMMAND_WAIT, |report| Some(report.clone()))?
            {
                Some(report) => {
                    self.silence.end();
                    self.take(report);
                }
                None if self.silence.is_too_long() => return Err(LinkError::Silent),
                None => {}
            }
        }
    }

    fn send(&mut self, command: Command) -> Result<(), DriveError> {
        let id = self.client.send(command)?;
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
            if !once && asked.last.elapsed() > REPEAT_AFTER {
                asked.last = Instant::now();
                asked.id = self.client.send(asked.command)?;
            }
        }
        Ok(())
    }

    fn take(&mut self, report: Report) {
        match &report {
            Report::Status { status, .. } => self.drives = is_driven(status.state),
            Report::Snapshot(_) | Report::Progress(_) => self.drives = true,
            Report::Fault(_) => self.drives = false,
            _ => {}
        }
        match report {
            Report::Done { id } => {
                if let Some(command) = self.was_asked(id) {
                    self.report_event(LinkEvent::Done(command));
                }
            }
            Report::Refused { id, refusal } => {
                if self.was_asked(id).is_some() {
                    self.report_event(LinkEvent::Refused(refusal));
                }
            }
            report => {
                if let Report::Settings { id, .. } = report {
                    self.was_asked(id);
                }
                self.report_event(LinkEvent::Report(report));
            }
        }
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
                self.client.stop()?;
                if self.drives {
                    Ending::Stopped
                } else {
                    Ending::WasDisabled
                }
            }
            AtEnd::Leave if is_driven(self.client.status()?.state) => Ending::Left,
            AtEnd::Leave => Ending::WasDisabled,
        };
        self.client.ask(Command::Watch(0))?;
        Ok(ending)
    }
}

fn is_driven(state: State) -> bool {
    matches!(state, State::Running | State::Commissioning)
}
