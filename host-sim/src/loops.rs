//! The loops that can be closed around a servo, all with one face: one control sample from a reference
//! and a measurement to a command.

mod batch;
mod direct;
mod feedback;
mod fixed;
mod learner;
mod pid;
mod relay;
mod two_degrees;

pub(crate) use batch::BatchLeastSquares;
pub(crate) use direct::Direct;
pub(crate) use fixed::FixedLoop;
pub(crate) use learner::{Beside, Learner, gamma_of};
pub(crate) use pid::PidLoop;
pub(crate) use relay::{Cycle, LeastSquares, RelayLoop, RelayMethod, TwoCycles};

pub(crate) use two_degrees::TwoDegreesLoop;

use identifier_core::identifier::Event;
use identifier_core::parameters::{PerParameter, ServoParameters};

use crate::experiment::Outcome;

/// What closes the loop around a servo and identifies it.
pub(crate) trait SimLoop {
    /// Why it can do no further sample.
    type Error;

    /// One control sample: from a reference, position units, and what the sensor shows to the command
    /// that acts until the next.
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, Self::Error>;

    /// What is known of it besides its samples: of its tuning, and at the end of its success.
    fn outcome(&self) -> Outcome {
        Outcome::default()
    }
}

/// What a sensor shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Measurement {
    /// An encoder: its counter, which wraps at 32 bits.
    Count(i32),
    /// An ideal sensor: the position, position units.
    Position(f64),
}

impl Measurement {
    /// What a loop that can only count takes it for: an ideal position counts as the last whole unit
    /// passed.
    pub(crate) fn count(self) -> i32 {
        match self {
            Self::Count(count) => count,
            // Wrapped as a counter is.
            Self::Position(position) => libm::floor(position) as i64 as i32,
        }
    }
}

/// What a loop did in a control sample, and what is seen of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    /// The whole command that acts, command units.
    pub(crate) command: f64,
    /// Velocity estimate, position units a sample, of loops that make one.
    pub(crate) velocity: Option<f64>,
    /// Output error ε = q − q_e, position units, of laws that have a model.
    pub(crate) output_error: Option<f64>,
    /// What happened besides learning.
    pub(crate) event: Option<Event>,
    /// The estimates, SI; [`NO_ESTIMATE`] while there are none.
    pub(crate) estimates: ServoParameters,
    /// Their standard errors, SI, for laws that have them.
    pub(crate) standard_errors: Option<ServoParameters>,
    /// Which estimates stand at a bound.
    pub(crate) at_bounds: PerParameter<bool>,
}

impl Step {
    /// That of a method without a model.
    pub(crate) fn direct(command: f64, estimates: Option<ServoParameters>) -> Self {
        Self {
            command,
            velocity: None,
            output_error: None,
            event: None,
            estimates: estimates.unwrap_or(NO_ESTIMATE),
            standard_errors: None,
            at_bounds: PerParameter::default(),
        }
    }
}

/// What stands for the estimates of a method that has none.
pub(crate) const NO_ESTIMATE: ServoParameters = ServoParameters {
    a: f64::NAN,
    b: f64::NAN,
    coulomb: f64::NAN,
    load: f64::NAN,
};
