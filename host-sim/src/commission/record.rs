use commissioning::{Phase, TrialResult};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::AxisForces;
use identifier_core::tuning::{Tuning, TuningError};

use super::{Course, FrequencyResponse};

/// The end of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Applied, rolled back or aborted.
    pub phase: Phase,
    /// The phase in which that was decided.
    pub within: Phase,
    /// The reason why there are no new gains, if there are none.
    pub reason: Option<Reason>,
    /// When, s.
    pub time: f64,
    /// When the stage was disabled, s; none while a loop holds the servo.
    pub disabled: Option<f64>,
}

/// Knowledge of the servo from a time on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Since when, s.
    pub time: f64,
    /// The servo.
    pub servo: IdentifiedServo,
}

/// The record of a commissioning once it has run.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Its end; none if it never did, which is a fault of the machine.
    pub end: Option<End>,
    /// The identified servo after each motion.
    pub known: Vec<Known>,
    /// The gains that were found, and their predicted response.
    pub tuning: Option<Tuning>,
    /// The reason why no gains were found, with the possible value.
    pub no_gains: Option<TuningError>,
    /// Measurements of the trial up to where it ended.
    pub trial: Option<TrialResult>,
    /// Standard deviation of the encoder's noise at rest before the first motion, rad; 0 where rounding hides it.
    pub noise: f64,
    /// The forces that it found beside the five numbers, from where the axis began.
    pub forces: AxisForces,
    /// The measured frequency response; none if the axis had too little travel for it.
    pub response: Option<FrequencyResponse>,
    /// Its phases, and how far the servo went.
    pub course: Course,
}

impl Outcome {
    /// True if the new gains hold.
    #[must_use]
    pub fn is_applied(&self) -> bool {
        self.end.is_some_and(|end| end.phase == Phase::Applied)
    }

    /// The servo as identified so far.
    #[must_use]
    pub fn servo(&self) -> Option<&IdentifiedServo> {
        self.known.last().map(|known| &known.servo)
    }

    /// The reason why they do not.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        self.end.and_then(|end| end.reason)
    }
}
