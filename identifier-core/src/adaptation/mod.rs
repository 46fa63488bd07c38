//! From output error and regressor (9) to parameters: the Γ-gradient estimator (11) and recursive Gauss–Newton.
//! Projections keep both within their bounds.

mod gain;
mod gauss_newton;
mod gradient;
mod identifiable_set;
mod projection;

pub(crate) use gain::Gain;
pub(crate) use gauss_newton::EstimateUncertainty;
pub(crate) use gauss_newton::{GaussNewton, GaussNewtonConfig, GaussNewtonState, GaussNewtonStep};
pub(crate) use gradient::{Gradient, GradientConfig, GradientStep};
pub use identifiable_set::IdentifiableSet;
pub(crate) use projection::Projection;
