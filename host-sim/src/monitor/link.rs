//! The line to the drive, in a thread of its own: however long a screen or a disk takes, it is listened to,
//! and the drive hears of us.

use std::fmt;
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use drive_link::{Command, Refusal, Report, State};

use crate::drive::{Client, DriveError};

/// How often the drive hears of us where it does not ask for it, s.
const SIGN_OF_LIFE: f64 = 4.0;

/// How long an order may have to wait.
const ATTENTION: Duration = Duration::from_millis(5);

/// How long a drive that answers may say nothing.
const LONGEST_SILENCE: Duration = Duration::from_secs(5);

/// When an order that was not answered is said again, and when nobody waits for an answer any more.
const AGAIN: Duration = Duration::from_millis(200);
const FORGET: Duration = Duration::from_secs(5);

/// How long a servo may take to be let go at the end.
const LET_GO: Duration = Duration::from_secs(3);

/// What becomes of a servo that is driven when nobody looks on any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtEnd {
    /// It is let go.
    Stop,
    /// It goes on.
    Leave,
}

/// What became of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Nothing drove it.
    WasLetGo,
    /// It was let go for the end.
    Stopped,
    /// It goes on.
    Left,
}

/// What is heard on the line.
#[derive(Debug)]
pub enum Heard {
    /// A report, but for answers.
    Report(Report),
    /// An order was done.
    Done(Command),
    /// An order was refused.
    Refused(Refusal),
    /// Nobody knows whether an order was done: no answer came.
    Unanswered(Command),
    /// The drive has gone.
    Lost(LinkError),
}

/// Why a drive has gone.
#[derive(Debug)]
#[non_exhaustive]
pub enum LinkError {
    /// The line broke.
    Drive(DriveError),
    /// The line is whole, and nobody is heard.
    Silent,
    /// It did not let the servo go when it was asked to.
    NotLetGo,
    /// The thread of the line has ended by a mistake of this program.
    Ended,
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drive(error) => error.fmt(f),
            Self::Silent => write!(
                f,
                "the drive has been silent for {} s: is it switched on, and its line connected?",
                LONGEST_SILENCE.as_secs()
            ),
            Self::NotLetGo => f.write_str("the drive was asked to stop and drives its servo still"),
            Self::Ended => f.write_str("the line is not listened to any more"),
        }
    }
}

impl std::error::Error for LinkError {}

impl From<DriveError> for LinkError {
    fn from(error: DriveError) -> Self {
        Self::Drive(error)
    }
}

/// A line that is listened to. However it is dropped, what is to become of the servo becomes of it.
#[derive(Debug)]
pub struct Link {
    orders: Option<Sender<Command>>,
    heard: Receiver<Heard>,
    thread: Option<JoinHandle<Result<Ending, LinkError>>>,
}

impl Link {
    /// Listens to a drive that goes on by itself for so long (s; 0 for ever) when nobody is heard.
    #[must_use]
    pub fn open(mut client: Client, link_timeout: f64, at_end: AtEnd) -> Self {
        client.keep_alive(if link_timeout > 0.0 {
            link_timeout
        } else {
            SIGN_OF_LIFE
        });
        let (orders, ordered) = mpsc::channel();
        let (tell, heard) = mpsc::channel();
        let thread = thread::spawn(move || {
            let mut talk = Talk {
                client,
                tell,
                unanswered: Vec::new(),
                heard: Instant::now(),
                drives: false,
            };
            match talk.go_on(&ordered) {
                Ok(()) => talk.end(at_end),
                Err(error) => {
                    // It is told to whoever looks on, or found where the link is closed.
                    let told = talk.tell.send(Heard::Lost(error));
                    told.map_or_else(|lost| Err(lost_in(lost.0)), |()| Ok(Ending::Left))
                }
            }
        });
        Self {
            orders: Some(orders),
            heard,
            thread: Some(thread),
        }
    }

    /// Orders something. What comes of it is heard.
    pub fn order(&self, command: Command) {
        if let Some(orders) = &self.orders {
            // A line that has gone says so itself.
            let _ = orders.send(command);
        }
    }

    /// What was heard since the last time, if anything was.
    pub fn hear(&self) -> Option<Heard> {
        match self.heard.try_recv() {
            Ok(heard) => Some(heard),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Heard::Lost(LinkError::Ended)),
        }
    }

    /// Ends it, and says what became of the servo.
    ///
    /// # Errors
    /// If the drive has gone, or does not let its servo go.
    pub fn close(mut self) -> Result<Ending, LinkError> {
        self.end()
    }

    fn end(&mut self) -> Result<Ending, LinkError> {
        self.orders = None;
        match self.thread.take() {
            Some(thread) => thread.join().unwrap_or(Err(LinkError::Ended)),
            None => Err(LinkError::Ended),
        }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        if self.thread.is_some() {
            // Nobody is there to be told.
            let _ = self.end();
        }
    }
}

fn lost_in(heard: Heard) -> LinkError {
    match heard {
        Heard::Lost(error) => error,
        _ => LinkError::Ended,
    }
}

fn is_driven(state: State) -> bool {
    matches!(state, State::Running | State::Commissioning)
}

/// The conversation in the thread.
struct Talk {
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
    /// Until nobody orders anything any more.
    fn go_on(&mut self, orders: &Receiver<Command>) -> Result<(), LinkError> {
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

    fn tell(&self, heard: Heard) {
        // Who does not look on any more ends the orders, too.
        let _ = self.tell.send(heard);
    }

    fn end(&mut self, at_end: AtEnd) -> Result<Ending, LinkError> {
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
