//! The line to the drive, in a thread of its own: however long a screen or a disk takes, it is listened to,
//! and the drive hears of us.

mod talk;

use std::fmt;
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, JoinHandle};

use drive_link::{Command, Refusal, Report};

use self::talk::{LONGEST_SILENCE, Talk};
use crate::drive::{Client, DriveError};

/// How often the drive hears of us where it does not ask for it, s.
const SIGN_OF_LIFE: f64 = 4.0;

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
            let mut talk = Talk::new(client, tell);
            match talk.go_on(&ordered) {
                Ok(()) => talk.end(at_end),
                Err(error) => talk.lose(error),
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
        let ended = self.thread.take().and_then(|thread| thread.join().ok());
        match ended {
            Some(Ok(ending)) => Ok(ending),
            Some(Err(LinkError::Ended)) | None => Err(self.lost().unwrap_or(LinkError::Ended)),
            Some(Err(error)) => Err(error),
        }
    }

    /// Why the drive has gone, if nobody has heard that yet.
    fn lost(&self) -> Option<LinkError> {
        self.heard.try_iter().find_map(|heard| match heard {
            Heard::Lost(error) => Some(error),
            _ => None,
        })
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
