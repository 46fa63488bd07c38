//! Methods to compare with: alternatives that a drive could run in place of the paper's.
//!
//! | estimator | idea | loop it is published with | assumes |
//! |---|---|---|---|
//! | [`FilteredLeastSquares`] | recursive least squares on filtered input and output, (2) with d = 0 | a relay (the paper's rival, its references 2 and 14) | no load, no friction |
//! | [`ClosedLoopArx`] | recursive ARX of the velocity on band-passed signals, as flight controllers identify themselves | any controller | a load that is constant (the band-pass drops it), no friction, a fine encoder |
//! | [`MechanicalLeastSquares`] | command = inertia · acceleration + viscous · velocity + offset, as motor-control firmware does it | any controller | no friction, a fine encoder |
//! | [`MultiStepLeastSquares`] | recursive extended least squares of a discrete-time model, several steps a sample (the paper's reference 6) | a proportional controller of low gain | no load, no friction |
//! | [`RelayCycles`], one | a relay with delay; the balance of one limit cycle gives model and friction (its reference 8) | its own | the cycle becomes steady |
//! | [`RelayCycles`], two | the limit cycles of two relays separate viscous from Coulomb friction (its reference 9) | its own | both cycles become steady |
//!
//! The [`DirectEstimator`]s need no controller, only command and motion of the servo; so they take recorded
//! logs too. Each gives no estimate in place of an impossible one (a pole outside the unit circle, a negative
//! inertia).

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod arx;
mod covariance;
mod filtered;
mod limit_cycle;
mod mechanical;
mod multi_step;
mod recursion;
mod regression;
mod relay;
mod state_variable_filter;

pub use arx::{ClosedLoopArx, ClosedLoopArxState};
pub use filtered::{FilteredLeastSquares, FilteredLeastSquaresState};
pub use limit_cycle::{LimitCycle, LimitCycleState};
pub use mechanical::{MechanicalLeastSquares, MechanicalLeastSquaresState};
pub use multi_step::{MultiStepLeastSquares, MultiStepLeastSquaresState};
pub use recursion::RecursionState;
pub use regression::{FilteredRegression, FilteredRegressionState};
pub use relay::{Relay, RelayCycles, RelayCyclesState, RelayState};
pub use state_variable_filter::{Filtered, StateVariableFilter};

use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};

/// A direct method: it needs command and motion of the servo, not the controller.
pub trait DirectEstimator<N: Number> {
    /// Its state between samples.
    type State: Copy + core::fmt::Debug;

    /// The parameters that it estimates.
    const PARAMETERS: &'static [Parameter];

    /// The state before the first sample.
    fn start(&self) -> Self::State;

    /// One sample: the increment of the measured position since the last (machine units), and the command
    /// that is held from now on.
    fn process(&self, state: &mut Self::State, increment: N, command: N);

    /// The estimates, SI, zero for parameters that it does not estimate; none while they cannot be those of
    /// a servo.
    fn estimates(&self, state: &Self::State) -> Option<ServoParameters>;
}

/// Configuration of the recursive least squares, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquaresConfig {
    /// Cut-off λ of the filters, rad/s: above the motion's frequencies, well below Nyquist.
    pub cutoff: f64,
    /// Forgetting factor, above 0 and at most 1. Its memory is T/(1 − factor) seconds.
    pub forgetting: f64,
    /// Initial â, 1/s.
    pub a: f64,
    /// Initial b̂, rad/s² per command unit; above zero.
    pub b: f64,
}

/// The estimates, where they can be those of a servo: finite, and b above zero.
fn plausible(servo: ServoParameters) -> Option<ServoParameters> {
    let ServoParameters {
        a,
        b,
        coulomb,
        load,
    } = servo;
    let finite = [a, b, coulomb, load].iter().all(|x| x.is_finite());
    (finite && b > 0.0).then_some(servo)
}
