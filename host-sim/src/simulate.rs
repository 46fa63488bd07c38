//! Simulated experiments: a loop closed around a simulated servo, sample by sample.
//!
//! Every loop on a simulated servo runs on the test rig. It is the only code that steps from sample to sample:
//! reference → sensor → loop → observer → servo. [`Simulation::build`] builds loop and rig from a scenario; faults of
//! the scenario are found then.

#[cfg(feature = "experiments")]
mod build;
mod checked;
#[cfg(not(feature = "experiments"))]
mod one_estimator;
mod sensor;
mod simulated_axis;

#[cfg(feature = "experiments")]
pub(crate) use build::{closed_by_pid, identifier};
#[cfg(not(feature = "experiments"))]
pub(crate) use one_estimator::identifier;
pub(crate) use simulated_axis::SimulatedAxis;

use std::fmt;

use crate::loops::SimLoop;
use crate::scenario::{Fault, Scenario};
use identifier_log::experiment::{Outcome, Sample};

/// A loop of any kind.
pub(crate) type LocalLoop = Box<dyn SimLoop>;

/// A loop and what it is closed around, ready to run.
pub struct Simulation {
    rig: SimulatedAxis<'static>,
    closed: LocalLoop,
}

impl fmt::Debug for Simulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Simulation").finish_non_exhaustive()
    }
}

impl Simulation {
    /// Runs it and shows every sample to `observe`.
    pub fn run(mut self, observe: &mut impl FnMut(&Sample)) -> Outcome {
        self.rig
            .run(self.closed.as_mut(), &mut |sample, _| observe(sample))
    }
}

/// Builds what a scenario describes, runs it and shows every sample to `observe`.
///
/// # Errors
/// The key that something cannot be built from; nothing has been observed then.
pub fn run(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Result<Outcome, Fault> {
    Ok(Simulation::build(scenario)?.run(observe))
}
