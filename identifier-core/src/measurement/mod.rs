//! From encoder counts to increments and velocity.
//!
//! register → [`counter`] → count → increment → [`velocity`] → velocity estimate. No position enters a
//! loop, only errors and increments, so there is no origin, and precision does not depend on the
//! distance from one.

pub mod counter;
pub(crate) mod direction;
pub mod standstill;
pub mod velocity;
