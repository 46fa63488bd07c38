//! From output error and regressor (9) to parameters: the Γ-gradient law (11), recursive Gauss–Newton,
//! and what keeps both within their bounds.

mod automatic_gain;
mod covariance;
mod evidence;
mod gain;
mod gauss_newton;
mod gradient;
pub(crate) mod levenberg_marquardt;
mod matrix;
mod normal_equations;
mod projection;

pub use automatic_gain::{AutomaticGain, GainError};
pub use covariance::{Covariance, Innovation};
pub use evidence::{Evidence, Gathered, OnDemand};
pub use gain::{DiagonalGain, FullGain, Gain};
pub(crate) use gauss_newton::Factors;
pub use gauss_newton::{
    FirstOrder, GaussNewton, GaussNewtonConfig, GaussNewtonState, GaussNewtonStep, Whitening,
};
pub use gradient::{Gradient, GradientConfig, GradientState, GradientStep, GradientWith};
pub use matrix::{MatrixError, PositiveDefinite};
pub use normal_equations::NormalEquations;
pub use projection::Projection;
