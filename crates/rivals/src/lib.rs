//! The method with which the paper compares its estimator: recursive least squares on filtered input and output, in
//! the loop of a relay (its references 2 and 14). The model is (2) with d = 0. It assumes a servo without load and
//! friction.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod covariance;
mod filtered;
mod recursion;
mod relay;
mod state_variable_filter;

pub use filtered::{FilteredLeastSquares, FilteredLeastSquaresState};
pub use relay::Relay;
pub use state_variable_filter::{Filtered, StateVariableFilter};

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
