//! The host's end of a drive's link.

mod driven;
mod loop_settings;
mod results;
mod silence;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use drive_link::{BoardTest, Command, Outcome, Refusal, Report, Request, Settings, State, Status};
use host_sim::commission::Recorded;

pub use self::driven::{AtEnd, Driven};
pub use self::loop_settings::{holding_brake, loop_settings, tables_of};
pub use self::results::{DriveCommissioningResult, DriveStatus, commissioning_outcome};
pub use self::silence::Silence;
use crate::port::{Port, PortError};

/// Longest wait for a report.
const MAX_REPORT_WAIT: Duration = Duration::from_secs(20);

/// Longest wait for an answer before the question is repeated.
const PATIENCE: Duration = Duration::from_millis(1000);

/// Times that a question is asked.
const TRIES: u32 = 5;

/// Longest time from one question for the drive's state to the next.
const MAX_SIGN_PERIOD: Duration = Duration::from_secs(1);

/// Longest time until an interruption is noticed.
const TICK: Duration = Duration::from_millis(20);

/// A drive at the other end of a port, to be looked at and set. It moves by a [`Driven`] only.
#[derive(Debug)]
pub struct Client {
    port: Port,
    /// The number of the last order, of this program or by the last status.
    last_order: Option<u32>,
    /// The request for the state that is repeated while listening, its period, and the time of the last one.
    sign: Option<(Command, Duration)>,
    last_sign: Instant,
    /// Ends every wait when it is set.
    interruption: Option<&'static AtomicBool>,
    /// Takes every report that it hears while it waits.
    reports: Option<Sender<Report>>,
}

/// Why a drive did not carry out a command.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DriveError {
    /// The line.
    #[error(transparent)]
    Port(#[from] PortError),
    /// No drive answers a question, which was repeated.
    #[error(transparent)]
    Unanswered(PortError),
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
    /// No stop was acknowledged.
    #[error(
        "stops were sent for 1 s and none was acknowledged: if the axis is still driven, press Ctrl-C in the program that \
         drives it, or switch the drive's enable or the motor's supply off"
    )]
    NotAcknowledged,
    /// The wait for the drive was interrupted.
    #[error("interrupted")]
    Interrupted,
}

impl Client {
    /// A client at a port.
    #[must_use]
    pub fn new(port: Port) -> Self {
        Self {
            port,
            last_order: None,
            sign: None,
            last_sign: Instant::now(),
            interruption: None,
            reports: None,
        }
    }

    /// Asks for the drive's state now and then while it listens. That keeps no run alive.
    pub fn poll(&mut self) {
        self.sign = Some((Command::Hello, MAX_SIGN_PERIOD));
    }

    /// The port, for bytes that are no requests.
    pub fn port(&mut self) -> &mut Port {
        &mut self.port
    }

    /// Sends a command without waiting for the answer, which will carry the returned number.
    fn send(&mut self, command: Command) -> Result<u8, DriveError> {
        let request = self.request(command)?;
        self.port.send(&request)?;
        Ok(request.id)
    }

    /// A request with the next numbers.
    fn request(&mut self, command: Command) -> Result<Request, DriveError> {
        let order = if command.may_move() {
            let last = match self.last_order {
                Some(last) => last,
                None => self.status()?.order,
            };
            *self.last_order.insert(last.wrapping_add(1))
        } else {
            0
        };
        let id = self.port.next_id();
        Ok(Request { id, order, command })
    }

    /// Sends a command and waits until it is done.
    fn ask(&mut self, command: Command) -> Result<(), DriveError> {
        self.report(command).map(|_| ())
    }

    /// Replaces the settings.
    ///
    /// # Errors
    /// If they are refused, or the line breaks.
    pub fn configure(&mut self, settings: Settings) -> Result<(), DriveError> {
        self.ask(Command::Configure(settings))
    }

    /// Reports a sample at this interval, samples; 0 for never.
    ///
    /// # Errors
    /// If it is refused, or the line breaks.
    pub fn watch(&mut self, every: u16) -> Result<(), DriveError> {
        self.ask(Command::Watch(every))
    }

    /// Clears a fault whose cause is gone.
    ///
    /// # Errors
    /// If it is refused, or the line breaks.
    pub fn clear(&mut self) -> Result<(), DriveError> {
        self.ask(Command::Clear)
    }

    /// Saves settings and estimates. The status afterwards, as home may be lost by it.
    ///
    /// # Errors
    /// If it is refused, or the line breaks.
    pub fn save(&mut self) -> Result<Status, DriveError> {
        self.status_after(Command::Save)
    }

    /// Stops everything that the drive does before it asks it anything, and returns its status when its servo is
    /// disabled. A stop is acknowledged before the sample that obeys it. Only after that sample are the estimates of the
    /// run complete.
    ///
    /// # Errors
    /// If the line breaks, or the drive does not stop. A drive that acknowledges the stop and refuses to tell its state
    /// is of another version.
    pub fn stop(&mut self) -> Result<Status, DriveError> {
        // It has led to this stop, and no sign of life may follow that.
        self.interruption = None;
        self.sign = None;
        for _ in 0..TRIES {
            let reports = self.reports.as_ref();
            let is_acknowledged = self.port.stop(&|report| {
                pass(reports, report.clone());
            })?;
            let until = Instant::now() + PATIENCE;
            while Instant::now() < until {
                match self.report_in(Command::Hello, 1) {
                    Ok(Report::Status { status, .. }) if !is_driven(status.state) => {
                        return Ok(status);
                    }
                    Err(_) if !is_acknowledged => return Err(DriveError::NotAcknowledged),
                    other => other?,
                };
            }
        }
        Err(DriveError::NotStopped)
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
                Report::MotionRecord { part, .. } => {
                    let taken = recorded.take_blocks(part.resolution, &part.blocks) as u16;
                    next = (taken < part.total && !part.blocks.is_empty()).then_some(taken);
                }
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
        self.status_after(Command::Hello)
    }

    fn status_after(&mut self, command: Command) -> Result<Status, DriveError> {
        match self.report(command)? {
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
            if self
                .interruption
                .is_some_and(|is_set| is_set.load(Ordering::Relaxed))
            {
                return Err(DriveError::Interrupted);
            }
            let now = Instant::now();
            let mut patience = until.saturating_duration_since(now).min(TICK);
            if patience.is_zero() {
                return Ok(None);
            }
            if let Some((command, period)) = self.sign {
                if now.duration_since(self.last_sign) >= period {
                    self.last_sign = now;
                    self.send(command)?;
                }
                patience = patience.min(period);
            }
            let Some(report) = self.port.listen(&|_: &Report| true, patience)? else {
                continue;
            };
            self.hear_orders(&report);
            let selected = select(&report);
            pass(self.reports.as_ref(), report);
            if selected.is_some() {
                return Ok(selected);
            }
        }
    }

    /// Takes in the orders of other programs.
    fn hear_orders(&mut self, report: &Report) {
        match report {
            Report::Status { status, .. } => {
                let is_later = |last| status.order.wrapping_sub(last).cast_signed() > 0;
                if self.last_order.is_none_or(is_later) {
                    self.last_order = Some(status.order);
                }
            }
            Report::Refused { refusal, .. } if *refusal == Refusal::GivenBefore => {
                self.last_order = None
            }
            _ => {}
        }
    }

    fn report(&mut self, command: Command) -> Result<Report, DriveError> {
        self.report_in(command, TRIES)
    }

    /// The report that answers a command, which is sent this often at most.
    fn report_in(&mut self, command: Command, tries: u32) -> Result<Report, DriveError> {
        let request = self.request(command)?;
        let id = request.id;
        let answers = |report: &Report| match report {
            Report::Status { id: same, .. } => *same == Some(id),
            Report::Settings { id: same, .. }
            | Report::Outcome { id: same, .. }
            | Report::MotionRecord { id: same, .. }
            | Report::BoardTest { id: same, .. }
            | Report::Done { id: same }
            | Report::Refused { id: same, .. } => *same == id,
            Report::Snapshot(_) | Report::Progress(_) | Report::Fault(_) => false,
        };
        for _ in 0..tries {
            self.port.send(&request)?;
            let answer =
                self.next_within(PATIENCE, |report| answers(report).then(|| report.clone()))?;
            match answer {
                Some(Report::Refused { refusal, .. }) => return Err(DriveError::Refused(refusal)),
                Some(report) => return Ok(report),
                None => {}
            }
        }
        Err(DriveError::Unanswered(self.port.unanswered()))
    }
}

/// Passes on a report.
fn pass(reports: Option<&Sender<Report>>, report: Report) {
    if let Some(reports) = reports {
        // Who has gone needs none.
        let _ = reports.send(report);
    }
}

/// The servo is driven in this state.
pub(crate) fn is_driven(state: State) -> bool {
    matches!(state, State::Running | State::Commissioning)
}
