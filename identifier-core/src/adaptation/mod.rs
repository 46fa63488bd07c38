//! From output error and regressor (9) to parameters: the Γ-gradient law (11), recursive Gauss–Newton,
//! and what keeps both within their bounds.

mod evidence;
mod gain;
mod gauss_newton;
mod gradient;
mod identifiable_set;
mod projection;

pub use evidence::{Evidence, Gathered, OnDemand};
pub use gain::{DiagonalGain, FullGain, Gain};
pub use gauss_newton::{
    FirstOrder, GaussNewton, GaussNewtonConfig, GaussNewtonState, GaussNewtonStep, Whitening,
};
pub use gradient::{Gradient, GradientConfig, GradientState, GradientStep, GradientWith};
pub use identifiable_set::IdentifiableSet;
pub use projection::Projection;
