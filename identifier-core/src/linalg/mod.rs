//! Small matrices: normal equations, the factors of a covariance, symmetric positive definite matrices.

mod factors;
mod normal_equations;
mod positive_definite;

pub(crate) use factors::Lower;
pub(crate) use factors::{Factors, Measurement};
pub(crate) use normal_equations::Factor;
pub use normal_equations::NormalEquations;
pub use positive_definite::MatrixError;
pub(crate) use positive_definite::PositiveDefinite;
