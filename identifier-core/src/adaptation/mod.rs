//! From output error and regressor to parameters.

mod automatic_gain;
mod gradient;
mod matrix;
mod projection;

pub use automatic_gain::AutomaticGain;
pub use gradient::{Gradient, GradientConfig, GradientState, GradientUpdate};
pub use matrix::{MatrixError, PositiveDefinite};
pub use projection::Projection;
