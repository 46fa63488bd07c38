//! Simulated experiments: a loop closed around a simulated servo, sample by sample.
//!
//! Whatever runs a loop on a simulated servo does it on the [test rig](rig::Rig), which alone goes from
//! sample to sample: reference → sensor → loop → observer → servo. [`Simulation::of`] builds loop and
//! rig from a scenario; what can be wrong with it is found then.

mod build;
mod operations;
mod rig;
mod sensor;

pub(crate) use build::{closed_by_pid, learner};
pub use operations::operations;
pub(crate) use rig::Rig;

use std::fmt;

use identifier_core::error::StepError;

use crate::experiment::{Abort, Outcome, Sample};
use crate::loops::SimLoop;
use crate::scenario::{Fault, Scenario};

/// A loop that runs on this machine.
pub(crate) type LocalLoop = Box<dyn SimLoop<Error = StepError>>;

/// A loop and what it is closed around, ready to run.
pub struct Simulation {
    rig: Rig<'static>,
    closed: LocalLoop,
}

impl fmt::Debug for Simulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Simulation").finish_non_exhaustive()
    }
}

impl Simulation {
    /// Runs it and shows every sample to `observe`.
    pub fn run(mut self, observe: &mut dyn FnMut(&Sample)) -> Outcome {
        let run = self
            .rig
            .run(self.closed.as_mut(), &mut |sample, _| observe(sample));
        Outcome {
            abort: run.stopped.map(|(time, error)| Abort { time, error }),
            ..run.outcome
        }
    }
}

/// Builds what a scenario describes, runs it and shows every sample to `observe`.
///
/// # Errors
/// The key that something cannot be built from; nothing has been observed then.
pub fn run(scenario: &Scenario, observe: &mut dyn FnMut(&Sample)) -> Result<Outcome, Fault> {
    Ok(Simulation::of(scenario)?.run(observe))
}
