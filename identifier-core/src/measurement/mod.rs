//! From encoder counts to increments and velocity.
//!
//! register → [`counter`] → count → increment → [`velocity`] → velocity estimate. No position enters
//! a loop, only errors and increments, so there is no origin and nothing is lost far from one.

pub mod counter;
pub mod standstill;
pub mod velocity;
