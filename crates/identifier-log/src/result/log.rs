//! The logs of a replay, and the errors of their predictions.

use serde::Serialize;

use crate::log::{Clock, Log};
use crate::motion_unit::MotionUnit;
use crate::predict::{ClosedLoop, Predicted};

/// Properties of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogReading {
    /// The file.
    pub file: String,
    /// Its samples, those that were bridged among them.
    pub samples: u64,
    /// Sample time, s.
    pub sample_time: f64,
    /// Root mean square of the time stamps' deviation from an even clock, part of a sample.
    pub jitter_rms: f64,
    /// Their largest deviation, part of a sample.
    pub jitter_max: f64,
    /// Gaps that were bridged.
    pub gaps: u64,
    /// Samples that straight lines stand in for.
    pub bridged_samples: u64,
    /// Rows in ranges of time that were left out.
    pub left_out_rows: u64,
    /// Positions that were left out: single ones far from those before and after.
    pub spikes: u64,
    /// Lines that were left out: of another width than all others.
    pub damaged_lines: u64,
    /// Name of the separator between columns; none of columns in memory.
    pub separator: Option<&'static str>,
    /// True if its numbers have decimal commas.
    pub decimal_commas: bool,
    /// How the text was read, where that is not plain.
    pub notes: Vec<String>,
    /// The unit of its positions as they are read.
    pub unit: MotionUnit,
    /// Smallest change of its positions, in that unit, and no finer than 2⁻²³ of their range.
    pub resolution: f64,
    /// Its largest command, either way, command units; none where it has no command.
    pub largest_command: Option<f64>,
    /// The period after which its positions begin again and were continued, in that unit.
    pub wrapped: Option<f64>,
    /// The clock of its rows: even, or as stamped.
    pub clock: &'static str,
}

impl LogReading {
    /// For logs, and for those that were only predicted.
    #[must_use]
    pub fn all(learnt: &[Log], predicted: &[Log]) -> Vec<Self> {
        let is_unseen = |log: &&Log| !learnt.iter().any(|own| own.is_same_file(log));
        let unseen = predicted.iter().filter(is_unseen);
        learnt.iter().chain(unseen).map(Self::new).collect()
    }

    /// For a log.
    #[must_use]
    pub fn new(log: &Log) -> Self {
        let found = &log.found;
        Self {
            file: log.path().display().to_string(),
            samples: log.samples,
            sample_time: log.sample_time,
            jitter_rms: found.jitter.rms,
            jitter_max: found.jitter.largest,
            gaps: found.gaps,
            bridged_samples: found.bridged,
            left_out_rows: found.left_out,
            spikes: found.spikes,
            damaged_lines: found.damaged,
            separator: found.separator,
            decimal_commas: found.decimal_commas,
            notes: found.notes.clone(),
            unit: log.settings().motion_unit(),
            resolution: Log::resolution(log.as_ref()),
            largest_command: log.largest_command(),
            wrapped: found.wrapped,
            clock: match found.clock {
                Clock::Even => "even",
                Clock::Stamped => "stamped",
            },
        }
    }
}

/// Errors of the prediction of a log by the frozen estimates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// The file.
    pub file: String,
    /// True if the estimates come from this log, too.
    pub learnt_from: bool,
    /// Errors under the declared controller; none without one.
    pub closed_loop: Option<ClosedLoop>,
    /// Errors under the recorded command; none without one.
    pub open_loop: Option<OpenLoopError>,
}

/// Position errors of the open-loop simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OpenLoopError {
    /// Samples that it covers.
    pub samples: u64,
    /// Root mean square, in the log's unit.
    pub rms: f64,
    /// Largest magnitude, in the log's unit.
    pub max: f64,
    /// The log's unit of position.
    pub unit: &'static str,
    /// Error relative to the motion.
    pub relative: f64,
}

impl Prediction {
    /// The reading of a log. `learnt_from`: the estimates come from it, too.
    #[must_use]
    pub fn new(log: &Log, learnt_from: bool, predicted: &Predicted) -> Self {
        let units = &log.settings().units;
        let (unit, name) = match log.settings().motion_unit() {
            MotionUnit::Stated(_) => (units.radians(units.position), units.position.name()),
            own => (1.0, own.name()),
        };
        Self {
            file: log.path().display().to_string(),
            learnt_from,
            closed_loop: predicted.closed_loop,
            open_loop: predicted.open_loop.as_ref().map(|found| OpenLoopError {
                samples: found.errors.len() as u64,
                rms: found.rms / unit,
                max: found.largest / unit,
                unit: name,
                relative: found.relative,
            }),
        }
    }
}
