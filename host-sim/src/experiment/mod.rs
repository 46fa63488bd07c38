//! One experiment: a true servo, the loop that the core closes around it, and what is seen of it.

mod baseline;
mod build;
mod closed_loop;
mod fixed_loop;
mod learner;
mod operations;
mod sample;
mod sensor;

pub(crate) use build::learner;
pub(crate) use fixed_loop::{check as check_words, known_beforehand};
pub(crate) use learner::Learner;
pub use operations::operations;
pub use sample::{Abort, Events, Outcome, Sample};

use crate::scenario::{Closing, Law, Scenario};

/// Runs a scenario and shows every sample to `observe`.
pub fn run(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Outcome {
    match (&scenario.identifier.law, scenario.identifier.law.closing()) {
        (Law::Baseline(baseline, settings), Closing::Relay | Closing::TwoDegreesOfFreedom) => {
            baseline::run(scenario, *baseline, settings, observe)
        }
        _ => closed_loop::run(scenario, observe),
    }
}
