//! From encoder counts to increments and velocity.
//!
//! register → [`Counter`] → count → increment → [`VelocityEstimate`] → velocity estimate. Only errors and increments
//! enter a loop, no position. So there is no origin, and precision does not depend on the distance from one.

pub(crate) mod angle;
pub(crate) mod counter;
pub(crate) mod direction;
pub(crate) mod standstill;
pub(crate) mod velocity;

pub use counter::Counter;
pub use velocity::{AveragedDifference, BackwardDifference, LowPass, Transfer, VelocityEstimate};
