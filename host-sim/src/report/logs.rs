//! What is said of the logs of a replay: how they were read, and what was predicted of them.

use std::fmt;

use serde::Serialize;

use crate::prediction::{ClosedLoop, OpenLoop};
use crate::replay::{Log, Predicted};

/// How a log was read.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct LogDocument {
    pub file: String,
    pub samples: u64,
    pub sample_time: f64,
    pub jitter_rms: f64,
    pub jitter_max: f64,
    pub gaps: u64,
    pub bridged_samples: u64,
    pub left_out_rows: u64,
    pub separator: Option<&'static str>,
    pub decimal_commas: bool,
    pub units_row: Option<String>,
}

impl LogDocument {
    /// Of a log.
    #[must_use]
    pub fn new(log: &Log) -> Self {
        let found = &log.found;
        Self {
            file: log.path().display().to_string(),
            samples: log.samples,
            sample_time: log.sample_time,
            jitter_rms: found.jitter.rms(),
            jitter_max: found.jitter.largest(),
            gaps: found.gaps,
            bridged_samples: found.bridged,
            left_out_rows: found.left_out,
            separator: found.separator,
            decimal_commas: found.decimal_commas,
            units_row: found.units_row.clone(),
        }
    }
}

impl fmt::Display for LogDocument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Jitter that text and rounding leave, part of a sample.
        const ROUNDED: f64 = 5e-3;
        write!(
            f,
            "{}: {} samples at {} Hz",
            self.file,
            self.samples,
            short(1.0 / self.sample_time)
        )?;
        if self.jitter_max > ROUNDED {
            write!(
                f,
                "; their time stamps jitter by {:.1} % of a sample rms, {:.0} % at most, and count as even",
                100.0 * self.jitter_rms,
                100.0 * self.jitter_max
            )?;
        }
        if self.bridged_samples > 0 {
            write!(
                f,
                "; {} missing samples in {} gaps were bridged by straight lines",
                self.bridged_samples, self.gaps
            )?;
        }
        if self.left_out_rows > 0 {
            write!(f, "; {} rows were left out", self.left_out_rows)?;
        }
        if let Some(separator) = self.separator
            && (separator != "comma" || self.decimal_commas)
        {
            let commas = if self.decimal_commas {
                " and decimal commas"
            } else {
                ""
            };
            write!(f, "; read with {separator}s between columns{commas}")?;
        }
        if let Some(units) = &self.units_row {
            write!(
                f,
                "; the row below the heading is no sample but units ({units})"
            )?;
        }
        Ok(())
    }
}

/// A number of six digits, without zeros at its end.
fn short(number: f64) -> f64 {
    let size = 10_f64.powf(5.0 - number.abs().log10().floor());
    (number * size).round() / size
}

/// What the frozen estimates predict of a log.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct PredictionDocument {
    pub file: String,
    pub learnt_from: bool,
    pub closed_loop: Option<ClosedLoopDocument>,
    pub open_loop: Option<OpenLoopDocument>,
}

/// Relative errors of the closed-loop simulation.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct ClosedLoopDocument {
    pub samples: u64,
    pub position: f64,
    pub velocity: f64,
    pub command: Option<f64>,
}

/// Position errors of the open-loop simulation.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct OpenLoopDocument {
    pub samples: u64,
    pub rms: f64,
    pub max: f64,
    pub unit: &'static str,
    pub relative: f64,
}

impl PredictionDocument {
    /// Of a log; `learnt_from` says whether the estimates come from it, too.
    #[must_use]
    pub fn new(log: &Log, learnt_from: bool, predicted: &Predicted) -> Self {
        let units = &log.settings().units;
        let unit = units.radians(units.position);
        Self {
            file: log.path().display().to_string(),
            learnt_from,
            closed_loop: predicted
                .closed_loop
                .map(|found: ClosedLoop| ClosedLoopDocument {
                    samples: found.samples,
                    position: found.position,
                    velocity: found.velocity,
                    command: found.command,
                }),
            open_loop: predicted.open_loop.map(|found: OpenLoop| OpenLoopDocument {
                samples: found.samples,
                rms: found.rms / unit,
                max: found.largest / unit,
                unit: units.position.name(),
                relative: found.relative,
            }),
        }
    }
}

impl fmt::Display for PredictionDocument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "prediction of {}", self.file)?;
        if self.learnt_from {
            write!(f, " (which the estimates were learnt from)")?;
        }
        match &self.closed_loop {
            Some(found) => {
                let per_cent = |part: f64| format!("{:.3} %", 100.0 * part);
                write!(
                    f,
                    ": closed loop, position {}, velocity {}",
                    per_cent(found.position),
                    per_cent(found.velocity)
                )?;
                if let Some(command) = found.command {
                    write!(f, ", command {}", per_cent(command))?;
                }
            }
            None => write!(
                f,
                ": no closed loop (it takes a declared controller and log.reference, and must stay in \
                 bounds)"
            )?,
        }
        match &self.open_loop {
            Some(found) => write!(
                f,
                "; open loop from a fitted start, position {:.4} {unit} rms, {:.4} {unit} at most \
                 ({:.2} %)",
                found.rms,
                found.max,
                100.0 * found.relative,
                unit = found.unit
            ),
            None => write!(
                f,
                "; no open loop (it takes log.command, and must stay in bounds)"
            ),
        }
    }
}
