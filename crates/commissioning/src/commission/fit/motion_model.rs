use super::PARAMETERS;
use identifier_core::fit::{Fit, Fitter};
use identifier_core::parameters::Unknowns;

/// The model of a motion: a, b, c, the delay and d.
pub(super) type MotionModel = Unknowns<5>;

/// A fitter of it.
pub(super) type MotionFitter<N> = Fitter<N, MotionModel, PARAMETERS>;

/// A fit of it under way.
pub(super) type MotionFit<N> = Fit<N, PARAMETERS>;
