//! From encoder counts to position and velocity.
//!
//! counter → [`counter`] → count → [`origin`] → position → [`velocity`] → velocity estimate

pub mod counter;
pub mod origin;
pub mod travel;
pub mod velocity;
