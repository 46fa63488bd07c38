//! One experiment: a true servo, the loop that the core closes around it, and what is seen of it.

mod build;
mod closed_loop;
mod learner;
mod relay_loop;
mod sample;

pub(crate) use build::learner;
pub(crate) use learner::Given;
pub use sample::{Abort, Outcome, Sample};

use crate::scenario::{Law, Scenario};

/// Runs a scenario and shows every sample to `observe`.
pub fn run(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Outcome {
    match &scenario.identifier.law {
        Law::Gradient(_) | Law::GaussNewton(..) | Law::Window(_) => {
            closed_loop::run(scenario, observe)
        }
        Law::RelayLeastSquares(settings) => relay_loop::run(scenario, settings, observe),
    }
}
