//! Samples and outcome of an experiment, simulated or replayed.

use std::fmt;

use identifier_core::error::StepError;
use identifier_core::identifier::Event;
use identifier_core::parameters::{Parameter, PerParameter, ServoParameters, Term, Unknown};
use identifier_core::reason::Reason;
use log_fit::Logged;
use serde::Serialize;

/// One sample of an experiment, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub time: f64,
    /// True where another motion begins: at the first sample of a run, and of every segment of a log.
    pub begins: bool,
    /// Reference q_d, rad; NaN where it is not known.
    pub reference: f64,
    /// Measured position q, rad.
    pub position: f64,
    /// The whole command that acts, u.
    pub command: f64,
    /// Output error ε = q − q_e, rad, for estimators that have a model.
    pub output_error: Option<f64>,
    /// The estimates, with the model's own value for a parameter that is not estimated. NaN while a method has none.
    pub estimates: ServoParameters,
    /// Their standard errors, for estimators that have them.
    pub standard_errors: Option<ServoParameters>,
    /// The estimates at a bound.
    pub at_bounds: PerParameter<bool>,
}

/// The estimates of a method that has none.
pub const NO_ESTIMATE: ServoParameters = ServoParameters::all(f64::NAN);

impl Sample {
    /// The position, and the command that acted, as a fit takes them.
    #[must_use]
    #[inline]
    pub fn logged(&self) -> Logged {
        Logged {
            position: self.position,
            command: self.command,
            begins: self.begins,
        }
    }

    /// Time, reference, position, command and output error, of what was measured and what the model left.
    #[must_use]
    pub fn measured(&self) -> [Option<f64>; 5] {
        [
            Some(self.time),
            Some(self.reference),
            Some(self.position),
            Some(self.command),
            self.output_error,
        ]
    }

    /// The estimates of a, b, c and d, then their standard errors in the same order.
    #[must_use]
    pub fn identified(&self) -> [Option<f64>; 8] {
        let values = [Some(self.estimates), self.standard_errors];
        let of = |values: Option<ServoParameters>| Parameter::ALL.map(|one| Some(values?.get(one)));
        std::array::from_fn(|place| of(values[place / 4])[place % 4])
    }
}

/// Record of an experiment once it has run.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Outcome {
    /// Samples run.
    #[serde(skip)]
    pub samples: u64,
    /// Counts of samples with something besides learning.
    #[serde(flatten)]
    pub events: Events,
    /// The optional terms that have entered, and the sample in which each did.
    #[serde(skip)]
    pub entered: Vec<(Term, u64)>,
    /// Their sizes, for those that have any.
    #[serde(skip)]
    pub terms: Vec<TermEstimate>,
    /// True if a parameter range was certified.
    pub certified: bool,
    /// The gain margin of the sampled loop over that range.
    pub gain_margin: Option<f64>,
    /// Γ over the model's parameters, SI, for the Γ-gradient estimator.
    pub gamma: Option<Vec<Vec<f64>>>,
    /// μ, 1/s, for the Γ-gradient estimator.
    pub mu: Option<f64>,
    /// Bandwidth of the model's correction at the end, rad/s, if the estimator chooses it online.
    #[serde(skip)]
    pub bandwidth: Option<f64>,
    /// Why an estimator that begins by a fit has none after a second of motion.
    #[serde(skip)]
    pub rejection_reason: Option<Reason>,
    /// The early end, if there was one.
    #[serde(skip)]
    pub abort: Option<Abort>,
}

/// The size of an optional term of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TermEstimate {
    /// Which.
    pub unknown: Unknown,
    /// Its value, SI.
    pub value: f64,
    /// Its standard error, SI.
    pub std_error: f64,
    /// The sample in which the term entered.
    pub since: u64,
}

/// Counts of samples with something besides learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Events {
    /// The guard shortened the estimator's step.
    #[serde(rename = "slowed_samples")]
    pub slowed: u64,
    /// The model left the range of the number format and was started again.
    #[serde(rename = "model_restarts")]
    pub restarted: u64,
    /// The servo stood, and nothing was learnt.
    #[serde(rename = "standing_samples")]
    pub standing: u64,
    /// A step of the load was taken over.
    pub load_steps: u64,
    /// The servo did not follow its command, and nothing was learnt.
    #[serde(rename = "not_following_samples")]
    pub not_following: u64,
}

impl Outcome {
    /// Counts a sample and what happened in it; a method without a model has no events.
    pub fn count(&mut self, event: Option<Event>) {
        self.samples += 1;
        let events = &mut self.events;
        match event {
            Some(Event::Slowed) => events.slowed += 1,
            Some(Event::Standing) => events.standing += 1,
            Some(Event::Restarted) => events.restarted += 1,
            Some(Event::LoadStep) => events.load_steps += 1,
            Some(Event::NotFollowing) => events.not_following += 1,
            _ => {}
        }
    }

    /// Ends the experiment early.
    pub fn end_early(&mut self, time: f64, error: StepError) {
        let cause = AbortCause::Loop(error);
        self.abort = Some(Abort { time, cause });
    }
}

/// An early end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Abort {
    /// When, s.
    pub time: f64,
    /// Why.
    pub cause: AbortCause,
}

/// Why an experiment ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AbortCause {
    /// The encoder gave no valid reading.
    NoReading,
    /// The loop could not take the sample.
    Loop(StepError),
}

impl fmt::Display for AbortCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoReading => {
                f.write_str("the encoder gave no valid reading: check its supply and wires")
            }
            Self::Loop(error) => error.fmt(f),
        }
    }
}
