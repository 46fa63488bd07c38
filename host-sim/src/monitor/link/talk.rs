//! What is said and heard in the line's thread.

use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::{Duration, Instant};

use drive_link::{Command, Report, State};

use super::{AtEnd, Ending, Heard, LinkError};
use crate::drive::{Client, DriveError};

/// How long an order may have to wait.
const ATTENTION: Duration = Duration::from_millis(5);

/// How long a drive that answers may say nothing.
pub(super) const LONGEST_SILENCE: Duration = Duration::from_secs(5);

/// When an order that was not answered is said again, and when nobody waits for an answer any more.
const AGAIN: Duration = Duration::from_millis(200);
const FORGET: Duration = Duration::from_secs(5);

/// How long a servo may take to be let go at the end.
const LET_GO: Duration = Duration::from_secs(3);

/// The conversation with a drive.
pub(super) struct Talk {
    client: Client,
    tell: Sender<Heard>,
    unanswered: Vec<Unanswered>,
    heard: Instant,
    /// Whether the servo is driven, as far as was heard.
    drives: bool,
}

/// An order on its way.
struct Unanswered {
    id: u8,
    command: Command,
    first: Instant,
    last: Instant,
}

impl Talk {
    pub(super) fn new(client: Client, tell: Sender<Heard>) -> Self {
        Self {
            client,
            tell,
            unanswered: Vec::new(),
            heard: Instant::now(),
            drives: false,
        }
    }

    /// Until nobody orders anything any more.
    pub(super) fn go_on(&mut self, orders: &Receiver<Command>) -> Result<(), LinkError> {
        loop {
            match orders.try_recv() {
                Ok(command) => self.say(command)?,
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => return Ok(()),
            }
            self.say_again()?;
            match self
                .client
                .next_within(ATTENTION, |report| Some(report.clone()))?
            {
                Some(report) => {
                    self.heard = Instant::now();
                    self.hear(report);
                }
                None if self.heard.elapsed() > LONGEST_SILENCE => return Err(LinkError::Silent),
                None => {}
            }
        }
    }

    fn say(&mut self, command: Command) -> Result<(), DriveError> {
        let id = self.client.say(command)?;
        let now = Instant::now();
        self.unanswered.push(Unanswered {
            id,
            command,
            first: now,
            last: now,
        });
        Ok(())
    }

    fn say_again(&mut self) -> Result<(), DriveError> {
        let mut silent = Vec::new();
        self.unanswered.retain(|asked| {
            let waits = asked.first.elapsed() < FORGET;
            if !waits {
                silent.push(asked.command);
            }
            waits
        });
        for command in silent {
            self.tell(Heard::Unanswered(command));
        }
        for asked in &mut self.unanswered {
            // Said twice, these could be done twice: once now, and once after they have ended.
            let once = matches!(asked.command, Command::Start | Command::Commission(_));
            if !once && asked.last.elapsed() > AGAIN {
                asked.last = Instant::now();
                asked.id = self.client.say(asked.command)?;
            }
        }
        Ok(())
    }

    fn hear(&mut self, report: Report) {
        match &report {
            Report::Status { status, .. } => self.drives = is_driven(status.state),
            Report::Snapshot(_) | Report::Progress(_) => self.drives = true,
            Report::Fault(_) => self.drives = false,
            _ => {}
        }
        match report {
            Report::Done { id } => {
                if let Some(command) = self.was_asked(id) {
                    self.tell(Heard::Done(command));
                }
            }
            Report::Refused { id, refusal } => {
                if self.was_asked(id).is_some() {
                    self.tell(Heard::Refused(refusal));
                }
            }
            report => {
                if let Report::Settings { id, .. } = report {
                    self.was_asked(id);
                }
                self.tell(Heard::Report(report));
            }
        }
    }

    /// The order that an answer is to. One that was said again may be answered twice.
    fn was_asked(&mut self, id: u8) -> Option<Command> {
        let place = self.unanswered.iter().position(|asked| asked.id == id)?;
        Some(self.unanswered.remove(place).command)
    }

    /// Tells that the drive has gone.
    pub(super) fn lose(&self, error: LinkError) -> Result<Ending, LinkError> {
        self.tell(Heard::Lost(error));
        Err(LinkError::Ended)
    }

    fn tell(&self, heard: Heard) {
        // Who does not look on any more ends the orders, too.
        let _ = self.tell.send(heard);
    }

    pub(super) fn end(&mut self, at_end: AtEnd) -> Result<Ending, LinkError> {
        let ending = match at_end {
            AtEnd::Stop => {
                // Whatever it does: nothing is to come before a stop.
                self.client.ask(Command::Stop)?;
                let until = Instant::now() + LET_GO;
                while is_driven(self.client.status()?.state) {
                    if Instant::now() > until {
                        return Err(LinkError::NotLetGo);
                    }
                }
                if self.drives {
                    Ending::Stopped
                } else {
                    Ending::WasLetGo
                }
            }
            AtEnd::Leave if is_driven(self.client.status()?.state) => Ending::Left,
            AtEnd::Leave => Ending::WasLetGo,
        };
        self.client.ask(Command::Watch(0))?;
        Ok(ending)
    }
}

fn is_driven(state: State) -> bool {
    matches!(state, State::Running | State::Commissioning)
}
