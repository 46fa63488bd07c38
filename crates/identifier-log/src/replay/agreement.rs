//! The recorded command against the declared controller.

use std::fmt;

use serde::Serialize;

/// Agreement of the declared controller with the recorded command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// True if the declared controller counts as the one that ran.
    pub holds: bool,
    /// Root mean square of the difference relative to the command's; of a command of zero the difference itself.
    pub relative: f64,
    /// The largest difference.
    pub largest: f64,
    /// The log that it is in, from 0.
    #[serde(skip)]
    pub log: usize,
    /// Its line in the file.
    pub line: u64,
}

impl Agreement {
    /// Relative difference up to which the declared controller counts as the one that ran.
    pub const TOLERANCE: f64 = 0.005;
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the declared controller reproduces the recorded command to {:.2} % rms (largest \
             difference {:.4} in line {}{})",
            100.0 * self.relative,
            self.largest,
            self.line,
            match self.log {
                0 => String::new(),
                log => format!(" of log {}", log + 1),
            }
        )?;
        if self.holds {
            return Ok(());
        }
        write!(
            f,
            ": more than {} % means that another controller ran; check gains, velocity filter, sample time, limit \
             and the columns. The model is driven by the recorded command",
            100.0 * Self::TOLERANCE
        )
    }
}

/// Gathers an [`Agreement`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Comparison {
    count: f64,
    command_squares: f64,
    difference_squares: f64,
    largest: f64,
    log: usize,
    line: u64,
}

impl Comparison {
    pub(super) fn add(&mut self, log: usize, line: u64, recorded: f64, declared: f64) {
        let difference = (declared - recorded).abs();
        self.count += 1.0;
        self.command_squares += recorded * recorded;
        self.difference_squares += difference * difference;
        if difference > self.largest {
            self.largest = difference;
            (self.log, self.line) = (log, line);
        }
    }

    pub(super) fn finish(&self) -> Option<Agreement> {
        if self.count == 0.0 {
            return None;
        }
        let rms = |squares: f64| (squares / self.count).sqrt();
        let (command, difference) = (rms(self.command_squares), rms(self.difference_squares));
        let relative = if command > 0.0 {
            difference / command
        } else {
            difference
        };
        Some(Agreement {
            holds: relative <= Agreement::TOLERANCE,
            relative,
            largest: self.largest,
            log: self.log,
            line: self.line,
        })
    }
}
