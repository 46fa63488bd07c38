//! The loops that can be closed around a servo, behind one trait. A control sample maps a reference and a measurement
//! to a command.

mod feedback;
#[cfg(feature = "experiments")]
mod fixed;
mod identifier;
mod pid;
#[cfg(feature = "experiments")]
mod relay;

#[cfg(feature = "experiments")]
pub(crate) use fixed::{FixedIdentifier, FixedLoop, known};
pub(crate) use identifier::{DynIdentifier, Running, WholeRecord};
pub(crate) use pid::PidLoop;
#[cfg(feature = "experiments")]
pub(crate) use relay::{DirectEstimator, RelayLoop};

use identifier_core::error::StepError;
use identifier_core::identifier::Event;
use identifier_core::parameters::{PerParameter, ServoParameters};

pub(crate) use identifier_log::experiment::NO_ESTIMATE;
use identifier_log::experiment::{Outcome, Sample};

/// A loop around a servo, with its identification.
pub(crate) trait SimLoop {
    /// One control sample: from a reference, position units, and a measurement to the command that acts
    /// until the next.
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError>;

    /// Its outcome besides its samples: tuning, and at the end success.
    fn outcome(&self) -> Outcome {
        Outcome::default()
    }
}

/// The reading of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Measurement {
    /// An encoder: its counter, which wraps at 32 bits.
    Count(i32),
    /// An ideal sensor: the position, position units.
    Position(f64),
}

impl Measurement {
    /// As a count: of an ideal position the last whole unit passed.
    #[cfg(feature = "experiments")]
    pub(crate) fn count(self) -> i32 {
        match self {
            Self::Count(count) => count,
            // Wrapped as a counter is.
            Self::Position(position) => libm::floor(position) as i64 as i32,
        }
    }
}

/// The result of a control sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    /// The whole command that acts, command units.
    pub(crate) command: f64,
    /// Velocity estimate, position units a sample, of loops that make one.
    pub(crate) velocity: Option<f64>,
    /// Output error ε = q − q_e, position units, of estimators that have a model.
    pub(crate) output_error: Option<f64>,
    /// The event of the sample.
    pub(crate) event: Option<Event>,
    /// The estimates, SI; [`NO_ESTIMATE`] while there are none.
    pub(crate) estimates: ServoParameters,
    /// Their standard errors, SI, for estimators that have them.
    pub(crate) standard_errors: Option<ServoParameters>,
    /// The estimates at a bound.
    pub(crate) at_bounds: PerParameter<bool>,
}

impl Step {
    /// The sample of this step; reference, position and `unit`, the position unit, rad.
    pub(crate) fn sample(
        &self,
        time: f64,
        begins: bool,
        reference: f64,
        position: f64,
        unit: f64,
    ) -> Sample {
        Sample {
            time,
            begins,
            reference,
            position,
            command: self.command,
            output_error: self.output_error.map(|error| error * unit),
            estimates: self.estimates,
            standard_errors: self.standard_errors,
            at_bounds: self.at_bounds,
        }
    }

    /// That of a method without a model.
    #[cfg(feature = "experiments")]
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
