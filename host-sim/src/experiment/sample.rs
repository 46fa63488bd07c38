use identifier_core::error::StepError;
use identifier_core::identifier::Bounds;
use identifier_core::model::ServoParameters;

use super::learner::Seen;

/// One sample of an experiment, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub time: f64,
    /// Reference q_d, rad.
    pub reference: f64,
    /// Measured position q, rad.
    pub position: f64,
    /// Command u.
    pub command: f64,
    /// Output error ε = q − q_e, rad, for laws that have a model.
    pub output_error: Option<f64>,
    /// The estimates; of what the law does not estimate, what its model takes for it. NaN while a
    /// method has none.
    pub estimates: ServoParameters,
    /// Their standard errors, for laws that have them.
    pub standard_errors: Option<ServoParameters>,
}

/// What is known of an experiment once it has run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outcome {
    /// Samples run.
    pub samples: u64,
    /// Samples in which the guard shortened the law's step.
    pub slowed: u64,
    /// Times that the model left the range of the number format and was started again.
    pub restarts: u64,
    /// Γ over the model's parameters, SI, for the Γ-gradient law.
    pub gamma: Option<Vec<Vec<f64>>>,
    /// μ, 1/s, for the Γ-gradient law.
    pub mu: Option<f64>,
    /// The box that the estimates were kept in, for laws that have one.
    pub bounds: Option<Bounds>,
    /// Whether a box of servos was certified.
    pub certified: bool,
    /// The gain margin of the sampled loop over that box.
    pub gain_margin: Option<f64>,
    /// Why a method that closes its own loop has no estimates at the end, if it has none.
    pub failure: Option<&'static str>,
    /// Why it ended early, if it did.
    pub abort: Option<Abort>,
}

impl Outcome {
    pub(crate) fn count<N>(&mut self, seen: &Seen<N>) {
        self.samples += 1;
        self.slowed += u64::from(seen.slowed);
        self.restarts += u64::from(seen.restarted);
    }
}

/// An early end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Abort {
    /// When, s.
    pub time: f64,
    /// Why.
    pub error: StepError,
}
