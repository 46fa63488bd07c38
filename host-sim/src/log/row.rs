//! A row of a log in SI, whatever file it is from.

use super::{Found, LogError};
use crate::scenario::LogQuantity;

/// The most rows of a log.
pub(super) const MAX_ROWS: u64 = 1_000_000_000;

/// One sample of a log, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The line of the file, from 1, the heading among them; of a bridged sample, that after the gap.
    pub line: u64,
    /// Time, s.
    pub time: f64,
    /// Reference position, where the log has one.
    pub reference: Option<f64>,
    /// Measured position.
    pub position: f64,
    /// The command that acted from here to the next sample, where the log has one.
    pub command: Option<f64>,
    /// Known signal behind the controller; zero where the log has none.
    pub injection: f64,
    /// Measured velocity, where the log has one.
    pub velocity: Option<f64>,
    /// True where a straight line stands in for samples that were not recorded.
    pub bridged: bool,
    /// True where the motion directly before is unknown: at the first row, and at the first behind a range
    /// that was left out.
    pub begins: bool,
}

impl Row {
    /// A row at a time, s, without its other quantities.
    pub(crate) fn at(line: u64, time: f64) -> Self {
        Self {
            line,
            time,
            reference: None,
            position: 0.0,
            command: None,
            injection: 0.0,
            velocity: None,
            bridged: false,
            begins: false,
        }
    }

    /// Sets one quantity, SI.
    pub(super) fn set(&mut self, quantity: LogQuantity, value: f64) {
        match quantity {
            LogQuantity::Time => self.time = value,
            LogQuantity::Reference => self.reference = Some(value),
            LogQuantity::Position => self.position = value,
            LogQuantity::Command => self.command = Some(value),
            LogQuantity::Injection => self.injection = value,
            LogQuantity::Velocity => self.velocity = Some(value),
        }
    }
}

/// The rows of a file, one at a time. Rows in ranges of time that are left out are passed over.
pub(super) trait Rows: Iterator<Item = Result<Row, LogError>> {
    /// Writes down what reading has found out so far about the file.
    fn describe(&self, found: &mut Found);
}

/// Checks that a number can be a measurement, s, rad or command units.
///
/// # Errors
/// The allowed range.
pub(super) fn check_magnitude(number: f64) -> Result<(), String> {
    const MAX: f64 = 1e12;
    if number.abs() <= MAX {
        return Ok(());
    }
    Err(format!(
        "in s, rad and command units a number is from -{MAX:e} to {MAX:e}"
    ))
}
