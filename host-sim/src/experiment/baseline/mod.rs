//! The methods that are there for comparison: those that learn beside a controller, and the loops
//! of those that close their own.

mod batch;
mod direct;
mod relay_loop;
mod two_degrees;

use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use rivals::{ClosedLoopArx, DirectEstimator, FilteredLeastSquares, MechanicalLeastSquares};

use super::learner::Learner;
use super::{Outcome, Sample};
use crate::scenario::{Baseline, BaselineSettings, CHECKED, Scenario};
use batch::BatchLeastSquares;
use direct::DirectLearner;

/// What stands for the estimates of a method that has none.
pub(crate) const NO_ESTIMATE: ServoParameters = ServoParameters {
    a: f64::NAN,
    b: f64::NAN,
    coulomb: f64::NAN,
    load: f64::NAN,
};

/// A baseline that learns beside whatever controller runs.
pub(super) fn learner<N: Number>(
    scenario: &Scenario,
    baseline: Baseline,
    settings: &BaselineSettings,
) -> Box<dyn Learner<N>> {
    let units = &scenario.units();
    let config = scenario.least_squares(settings);
    match baseline {
        Baseline::ClosedLoopArx => {
            boxed::<N, _>(ClosedLoopArx::new(units, &config).expect(CHECKED))
        }
        Baseline::MechanicalLeastSquares => {
            boxed::<N, _>(MechanicalLeastSquares::new(units, &config).expect(CHECKED))
        }
        Baseline::MultiStepLeastSquares => {
            boxed::<N, _>(scenario.multi_step(settings).expect(CHECKED))
        }
        Baseline::ProportionalLeastSquares => Box::new(BatchLeastSquares::new(units, settings)),
        Baseline::RelayLeastSquares => {
            boxed::<N, _>(FilteredLeastSquares::new(units, &config).expect(CHECKED))
        }
        Baseline::RelayCycle | Baseline::TwoRelays | Baseline::TwoDegreesOfFreedom => {
            unreachable!("it closes a loop of its own")
        }
    }
}

fn boxed<N: Number, E: DirectEstimator<N> + 'static>(estimator: E) -> Box<dyn Learner<N>> {
    Box::new(DirectLearner::new(estimator))
}

/// Runs a baseline that closes its loop with a relay, each of its samples within `around`.
pub(super) fn measure<N: Number>(
    scenario: &Scenario,
    baseline: Baseline,
    settings: &BaselineSettings,
    around: &mut dyn FnMut(&mut dyn FnMut() -> N) -> N,
) {
    relay_loop::run_in::<N>(scenario, baseline, settings, &mut |_| (), around);
}

/// Runs a baseline that closes a loop of its own.
pub(super) fn run(
    scenario: &Scenario,
    baseline: Baseline,
    settings: &BaselineSettings,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    match baseline {
        Baseline::TwoDegreesOfFreedom => two_degrees::run(scenario, settings, observe),
        _ => relay_loop::run(scenario, baseline, settings, observe),
    }
}
