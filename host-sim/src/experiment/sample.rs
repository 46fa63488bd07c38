use identifier_core::adaptation::PositiveDefinite;
use identifier_core::error::StepError;
use identifier_core::interval::Interval;

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
    /// â, 1/s.
    pub a: f64,
    /// b̂, rad/s² per command unit.
    pub b: f64,
    /// d̂, rad/s², for laws that estimate it.
    pub load: Option<f64>,
}

/// What is known of an experiment once it has run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outcome {
    /// Samples run.
    pub samples: u64,
    /// Samples in which the guard shortened the law's step.
    pub slowed: u64,
    /// Times that the model left the range of the number format and was started again.
    pub restarts: u64,
    /// Γ, SI, for the Γ-gradient law.
    pub gamma: Option<PositiveDefinite<2>>,
    /// μ, 1/s, for the Γ-gradient law.
    pub mu: Option<f64>,
    /// The box that the estimates [â, b̂] were kept in, for laws that have one.
    pub bounds: Option<[Interval; 2]>,
    /// Whether a box of servos was certified.
    pub certified: bool,
    /// The gain margin of the sampled loop over that box.
    pub gain_margin: Option<f64>,
    /// Why it ended early, if it did.
    pub abort: Option<Abort>,
}

/// An early end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Abort {
    /// When, s.
    pub time: f64,
    /// Why.
    pub error: StepError,
}
