//! The host's end of the conversation with a drive.

mod document;
mod loop_settings;

use std::fmt;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use drive_link::{Command, Outcome, Refusal, Report, Request, Settings, State, Status};
use identifier_core::commission::CommissionSettings;

pub use self::document::CommissionDocument;
pub use self::loop_settings::loop_settings;
use crate::port::{Port, PortError};

/// A drive at the other end of a port.
#[derive(Debug)]
pub struct Client {
    port: Port,
    id: u8,
    /// How often the drive hears of us while we only listen, and when it last did.
    keep_alive: Option<Duration>,
    spoke: Instant,
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
    /// How long a report is waited for.
    const PATIENCE: Duration = Duration::from_secs(20);

    /// The longest time from one sign of life to the next, s.
    const SELDOM: f64 = 1.0;

    /// The drive hears of us several times within its link timeout.
    const OFTEN: f64 = 4.0;

    /// Talks over a port.
    #[must_use]
    pub fn new(port: Port) -> Self {
        // Not where the program before this one began: its last answer may still be on the line.
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let id = now.map_or(0, |now| (now.subsec_micros() >> 4) as u8);
        Self {
            port,
            id,
            keep_alive: None,
            spoke: Instant::now(),
        }
    }

    /// From now on, lets a drive with this link timeout (s; 0 for none) hear of us while we listen.
    pub fn keep_alive(&mut self, link_timeout: f64) {
        let often = (link_timeout / Self::OFTEN).min(Self::SELDOM);
        self.keep_alive = (often > 0.0).then(|| Duration::from_secs_f64(often));
    }

    /// The port, for whoever says something else than requests.
    pub fn port(&mut self) -> &mut Port {
        &mut self.port
    }

    /// Says something without waiting for the answer, which will carry this number.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn say(&mut self, command: Command) -> Result<u8, DriveError> {
        self.id = self.id.wrapping_add(1);
        self.spoke = Instant::now();
        let id = self.id;
        self.port.send(&Request { id, command })?;
        Ok(id)
    }

    /// Asks for something that is answered by being done.
    ///
    /// # Errors
    /// If it is refused, or the line breaks.
    pub fn ask(&mut self, command: Command) -> Result<(), DriveError> {
        self.report(command).map(|_| ())
    }

    /// Starts a run, and never two: where no answer comes, the drive is asked whether it runs.
    ///
    /// # Errors
    /// If it is refused, the line breaks, or the run has already ended.
    pub fn start(&mut self) -> Result<(), DriveError> {
        const PATIENCE: Duration = Duration::from_millis(200);
        self.begin(Command::Start, PATIENCE, State::Running)
    }

    /// Begins a commissioning, and never two. Before it begins, the drive's flash may have to be erased.
    ///
    /// # Errors
    /// If it is refused, the line breaks, or it has already ended.
    pub fn commission(&mut self, order: &CommissionSettings) -> Result<(), DriveError> {
        const PATIENCE: Duration = Duration::from_secs(5);
        let command = Command::Commission(*order);
        self.begin(command, PATIENCE, State::Commissioning)
    }

    /// Asks once for what must not be done twice; where no answer comes, the drive is asked whether it
    /// does it.
    fn begin(
        &mut self,
        command: Command,
        patience: Duration,
        wanted: State,
    ) -> Result<(), DriveError> {
        self.say(command)?;
        let id = self.id;
        let answer = self.next_within(patience, |report| match report {
            Report::Done { id: same } if *same == id => Some(Ok(())),
            Report::Refused { id: same, refusal } if *same == id => Some(Err(refusal.clone())),
            _ => None,
        })?;
        match answer {
            Some(done) => done.map_err(DriveError::Refused),
            None if self.status()?.state == wanted => Ok(()),
            None => Err(DriveError::Silent),
        }
    }

    /// What the last commissioning came to.
    ///
    /// # Errors
    /// If there was none, or the line breaks.
    pub fn outcome(&mut self) -> Result<Outcome, DriveError> {
        match self.report(Command::Outcome)? {
            Report::Outcome { outcome, .. } => Ok(outcome),
            _ => Err(DriveError::Silent),
        }
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
        self.next_within(Self::PATIENCE, says)?
            .ok_or(DriveError::Silent)
    }

    /// The same, if it comes within a time.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn next_within<T>(
        &mut self,
        time: Duration,
        says: impl Fn(&Report) -> Option<T>,
    ) -> Result<Option<T>, DriveError> {
        let until = Instant::now() + time;
        loop {
            let now = Instant::now();
            let mut patience = until.saturating_duration_since(now);
            if patience.is_zero() {
                return Ok(None);
            }
            if let Some(often) = self.keep_alive {
                if now.duration_since(self.spoke) >= often {
                    self.say(Command::Hello)?;
                }
                patience = patience.min(often);
            }
            let heard = self
                .port
                .listen(&|report: &Report| says(report).is_some(), patience)?;
            if let Some(said) = heard.as_ref().and_then(&says) {
                return Ok(Some(said));
            }
        }
    }

    fn report(&mut self, command: Command) -> Result<Report, DriveError> {
        self.id = self.id.wrapping_add(1);
        let id = self.id;
        let fits = |report: &Report| match report {
            Report::Status { id: same, .. } => *same == Some(id),
            Report::Settings { id: same, .. }
            | Report::Outcome { id: same, .. }
            | Report::Done { id: same }
            | Report::Refused { id: same, .. } => *same == id,
            Report::Snapshot(_) | Report::Progress(_) | Report::Fault(_) => false,
        };
        self.spoke = Instant::now();
        match self.port.ask(&Request { id, command }, fits)? {
            Report::Refused { refusal, .. } => Err(DriveError::Refused(refusal)),
            report => Ok(report),
        }
    }
}
