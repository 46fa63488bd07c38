//! The host's end of a drive's link.

mod loop_settings;
mod silence;

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use commissioning::CommissionSettings;
use drive_link::{BoardTest, Command, Outcome, Refusal, Report, Request, Settings, State, Status};
use host_sim::commission::Recorded;

pub use self::loop_settings::loop_settings;
pub use self::silence::Silence;
use crate::port::{Port, PortError};

/// Longest wait for a report.
const MAX_REPORT_WAIT: Duration = Duration::from_secs(20);

/// Longest time from one sign of life to the next, s.
const MAX_SIGN_PERIOD: f64 = 1.0;

/// Signs of life within the drive's link timeout.
const SIGNS_PER_TIMEOUT: f64 = 4.0;

/// A drive at the other end of a port.
#[derive(Debug)]
pub struct Client {
    port: Port,
    id: u8,
    /// Period of signs of life while listening, and the time of the last message.
    keep_alive: Option<Duration>,
    last_sent: Instant,
}

/// Why a drive did not carry out a command.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DriveError {
    /// The line.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The drive refused; nothing changed.
    #[error("the drive refuses: {0}")]
    Refused(Refusal),
    /// The drive does not report.
    #[error("the drive is silent: is it switched on and connected?")]
    Silent,
    /// It reports that it still drives its servo after it has taken a stop.
    #[error(
        "the drive accepted the stop but still drives its servo: switch the motor's supply off"
    )]
    NotStopped,
}

impl Client {
    /// A client at a port.
    #[must_use]
    pub fn new(port: Port) -> Self {
        // Random, as the last answer to the program before this one may still be on the line.
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let id = now.map_or(0, |now| (now.subsec_micros() >> 4) as u8);
        Self {
            port,
            id,
            keep_alive: None,
            last_sent: Instant::now(),
        }
    }

    /// Keeps a run of a drive with this link timeout (s; 0 for none) alive from now on, while it listens.
    pub fn keep_alive(&mut self, link_timeout: f64) {
        let period = if link_timeout > 0.0 {
            (link_timeout / SIGNS_PER_TIMEOUT).min(MAX_SIGN_PERIOD)
        } else {
            MAX_SIGN_PERIOD
        };
        self.keep_alive = Some(Duration::from_secs_f64(period));
    }

    /// The port, for bytes that are no requests.
    pub fn port(&mut self) -> &mut Port {
        &mut self.port
    }

    /// Sends a command without waiting for the answer, which will carry the returned number.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn send(&mut self, command: Command) -> Result<u8, DriveError> {
        self.id = self.id.wrapping_add(1);
        self.last_sent = Instant::now();
        let id = self.id;
        self.port.send(&Request { id, command })?;
        Ok(id)
    }

    /// Sends a command and waits until it is done.
    ///
    /// # Errors
    /// If it is refused, or the line breaks.
    pub fn ask(&mut self, command: Command) -> Result<(), DriveError> {
        self.report(command).map(|_| ())
    }

    /// Starts a run, and never two: without an answer, the drive's state decides.
    ///
    /// # Errors
    /// If it is refused, the line breaks, or the run has already ended.
    pub fn start(&mut self) -> Result<(), DriveError> {
        const PATIENCE: Duration = Duration::from_millis(200);
        self.begin(Command::Start, PATIENCE, State::Running)
    }

    /// Stops everything that the drive does, and returns when its servo is disabled. A stop is answered before the
    /// sample that obeys it. Only after that sample are the estimates of the run complete.
    ///
    /// # Errors
    /// If the line breaks, or the drive does not stop.
    pub fn stop(&mut self) -> Result<(), DriveError> {
        self.ask(Command::Stop)?;
        let until = Instant::now() + MAX_REPORT_WAIT;
        while matches!(self.status()?.state, State::Running | State::Commissioning) {
            if Instant::now() > until {
                return Err(DriveError::NotStopped);
            }
        }
        Ok(())
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

    /// Sends a command once that must not be done twice. Without an answer, the drive's state decides whether it was
    /// done.
    fn begin(
        &mut self,
        command: Command,
        patience: Duration,
        wanted: State,
    ) -> Result<(), DriveError> {
        self.send(command)?;
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

    /// The result of the last commissioning.
    ///
    /// # Errors
    /// If there was none, or the line breaks.
    pub fn outcome(&mut self) -> Result<Outcome, DriveError> {
        match self.report(Command::Outcome)? {
            Report::Outcome { outcome, .. } => Ok(outcome),
            _ => Err(DriveError::Silent),
        }
    }

    /// The record that the drive keeps of its last commissioning.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn recorded(&mut self) -> Result<Recorded, DriveError> {
        let mut recorded = Recorded::default();
        let mut next = Some(0);
        while let Some(first) = next {
            match self.report(Command::MotionRecord(first))? {
                Report::MotionRecord { part, .. } => next = recorded.take_part(&part),
                _ => return Err(DriveError::Silent),
            }
        }
        Ok(recorded)
    }

    /// The test of the drive's board.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn board_test(&mut self) -> Result<BoardTest, DriveError> {
        match self.report(Command::BoardTest)? {
            Report::BoardTest { test, .. } => Ok(test),
            _ => Err(DriveError::Silent),
        }
    }

    /// The drive's status.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn status(&mut self) -> Result<Status, DriveError> {
        match self.report(Command::Hello)? {
            Report::Status { status, .. } => Ok(status),
            _ => Err(DriveError::Silent),
        }
    }

    /// The settings in force.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn settings(&mut self) -> Result<Settings, DriveError> {
        match self.report(Command::Show)? {
            Report::Settings { settings, .. } => Ok(settings),
            _ => Err(DriveError::Silent),
        }
    }

    /// The first value that `select` takes from a report.
    ///
    /// # Errors
    /// If none comes, or the line breaks.
    pub fn next<T>(&mut self, select: impl Fn(&Report) -> Option<T>) -> Result<T, DriveError> {
        self.next_within(MAX_REPORT_WAIT, select)?
            .ok_or(DriveError::Silent)
    }

    /// The same, if it comes within a time.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn next_within<T>(
        &mut self,
        time: Duration,
        select: impl Fn(&Report) -> Option<T>,
    ) -> Result<Option<T>, DriveError> {
        let until = Instant::now() + time;
        loop {
            let now = Instant::now();
            let mut patience = until.saturating_duration_since(now);
            if patience.is_zero() {
                return Ok(None);
            }
            if let Some(period) = self.keep_alive {
                if now.duration_since(self.last_sent) >= period {
                    self.send(Command::Hello)?;
                }
                patience = patience.min(period);
            }
            let report = self
                .port
                .listen(&|report: &Report| select(report).is_some(), patience)?;
            if let Some(value) = report.as_ref().and_then(&select) {
                return Ok(Some(value));
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
            | Report::MotionRecord { id: same, .. }
            | Report::BoardTest { id: same, .. }
            | Report::Done { id: same }
            | Report::Refused { id: same, .. } => *same == id,
            Report::Snapshot(_) | Report::Progress(_) | Report::Fault(_) => false,
        };
        self.last_sent = Instant::now();
        match self.port.ask(&Request { id, command }, fits)? {
            Report::Refused { refusal, .. } => Err(DriveError::Refused(refusal)),
            report => Ok(report),
        }
    }
}
