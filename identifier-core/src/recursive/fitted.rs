use crate::constants::{Encode, encode};
use crate::linalg::Factors;
use crate::parameters::Parameter;

/// A fit result prepared for a recursion over any unknowns: 21 words in `f32`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonFitted<N> {
    /// The number of the last block that it used.
    pub(super) last: u32,
    /// None if the motion could not be explained.
    pub(super) explained: Option<FirstFitSolution<N>>,
}

/// The parameters that a fit without terms finds: a, b, Coulomb friction, load.
pub(super) const FITTED: usize = Parameter::ALL.len();

/// The factor on the covariance of a fit: its gradients were taken far from the truth, and its errors are not white.
pub(super) const COVARIANCE_FACTOR: f64 = 4.0;

/// The place of b among them.
pub(super) const B: usize = Parameter::B as usize;

/// The result of a fit that explains the motion, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FirstFitSolution<N> {
    pub(super) estimates: [N; FITTED],
    pub(super) covariance: Factors<N, [N; FITTED * (FITTED - 1) / 2], FITTED>,
    /// Variance of the fit's errors, counts².
    pub(super) unexplained: N,
    /// Variance of the position's noise over that of the settings, at least one, and its reciprocal root.
    pub(super) noise: N,
    pub(super) per_noise: N,
    /// Root mean square of acceleration over that of velocity, 1/sample.
    pub(super) bandwidth: N,
    /// Root mean square of the acceleration that the command gives, counts per sample².
    pub(super) acceleration: N,
    /// The motion never reversed.
    pub(super) one_way: bool,
}

encode! {
    [N: Encode] FirstFitSolution<N> as "FirstFitSolution" {
        estimates, covariance, unexplained, noise, per_noise, bandwidth, acceleration, one_way,
    }
}
