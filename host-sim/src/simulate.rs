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
mod rig_of_scenario;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Estimator, PAPER, Purpose};

    fn paper() -> Scenario {
        Scenario::parse("paper.toml", PAPER, Purpose::Run).expect("valid")
    }

    #[test]
    fn a_part_that_cannot_be_built_names_its_key_and_runs_no_sample() {
        let refused = |change: &dyn Fn(&mut Scenario)| {
            let mut scenario = paper();
            change(&mut scenario);
            let fault = run(&scenario, &mut |_| panic!("a sample")).expect_err("it cannot be");
            fault.key
        };
        assert_eq!(refused(&|s| s.plant = None), "plant");
        assert_eq!(
            refused(&|s| s.stated.cutoff = -1.0),
            "controller.velocity_filter.cutoff"
        );
        let key = refused(&|s| {
            s.identifier.set_estimator(Estimator::RelayLeastSquares);
            s.identifier.rival.filter_cutoff = 1e9;
        });
        assert_eq!(key, "identifier.filter_cutoff");
    }

    #[test]
    fn a_servo_that_outruns_its_encoder_ends_the_run_with_the_time() {
        let mut scenario = paper();
        let servo = scenario.plant.as_mut().expect("a run has a plant");
        servo.b *= 1e6;
        let mut last = 0.0;
        let outcome = run(&scenario, &mut |sample| last = sample.time).expect("it can be built");
        let abort = outcome.abort.expect("it stops");
        assert_eq!(outcome.samples, (abort.time * 1e3).round() as u64);
        assert!((abort.time - last - scenario.sample_time()).abs() < 1e-9);
    }
}
