//! The host's end of the conversation with a drive.

use std::fmt;
use std::time::{SystemTime, UNIX_EPOCH};

use drive_link::{Command, Refusal, Report, Request, Settings, Status};

use crate::port::{Port, PortError};

/// A drive at the other end of a port.
#[derive(Debug)]
pub struct Client {
    port: Port,
    id: u8,
}

/// Why a drive did not do what it was asked.
#[derive(Debug)]
#[non_exhaustive]
pub enum DriveError {
    /// The line.
    Port(PortError),
    /// The drive refused; nothing changed.
    Refused(Refusal),
    /// The drive is silent where it should report.
    Silent,
}

impl fmt::Display for DriveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Port(error) => error.fmt(f),
            Self::Refused(refusal) => write!(f, "the drive refuses: {refusal}"),
            Self::Silent => {
                f.write_str("the drive reports nothing of the kind: is its loop closed?")
            }
        }
    }
}

impl std::error::Error for DriveError {}

impl From<PortError> for DriveError {
    fn from(error: PortError) -> Self {
        Self::Port(error)
    }
}

impl Client {
    /// How often a report is waited for, in patiences of the port.
    const PATIENCE: u32 = 20;

    /// Talks over a port.
    #[must_use]
    pub fn new(port: Port) -> Self {
        // Not where the program before this one began: its last answer may still be on the line.
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let id = now.map_or(0, |now| (now.subsec_micros() >> 4) as u8);
        Self { port, id }
    }

    /// The port, for whoever says something else than requests.
    pub fn port(&mut self) -> &mut Port {
        &mut self.port
    }

    /// Asks for something that is answered by being done.
    ///
    /// # Errors
    /// If it is refused, or the line breaks.
    pub fn ask(&mut self, command: Command) -> Result<(), DriveError> {
        self.report(command).map(|_| ())
    }

    /// Who is there, and how.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn status(&mut self) -> Result<Status, DriveError> {
        match self.report(Command::Hello)? {
            Report::Status { status, .. } => Ok(status),
            _ => Err(DriveError::Silent),
        }
    }

    /// The settings that hold.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn settings(&mut self) -> Result<Settings, DriveError> {
        match self.report(Command::Show)? {
            Report::Settings { settings, .. } => Ok(settings),
            _ => Err(DriveError::Silent),
        }
    }

    /// What the next report of a kind says.
    ///
    /// # Errors
    /// If none comes, or the line breaks.
    pub fn next<T>(&mut self, says: impl Fn(&Report) -> Option<T>) -> Result<T, DriveError> {
        for _ in 0..Self::PATIENCE {
            let heard = self
                .port
                .listen(&|report: &Report| says(report).is_some())?;
            if let Some(said) = heard.as_ref().and_then(&says) {
                return Ok(said);
            }
        }
        Err(DriveError::Silent)
    }

    fn report(&mut self, command: Command) -> Result<Report, DriveError> {
        self.id = self.id.wrapping_add(1);
        let id = self.id;
        let fits = |report: &Report| match report {
            Report::Status { id: same, .. } => *same == Some(id),
            Report::Settings { id: same, .. }
            | Report::Done { id: same }
            | Report::Refused { id: same, .. } => *same == id,
            Report::Snapshot(_) | Report::Fault(_) => false,
        };
        match self.port.ask(&Request { id, command }, fits)? {
            Report::Refused { refusal, .. } => Err(DriveError::Refused(refusal)),
            report => Ok(report),
        }
    }
}
