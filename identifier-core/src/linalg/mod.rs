//! Small matrices: normal equations and the factors of a covariance.

mod factors;
mod normal_equations;

pub(crate) use factors::{Factors, Lower, Measurement};
pub(crate) use normal_equations::Factor;
pub use normal_equations::NormalEquations;
