//! The simulator of the servo identifier.

pub mod experiment;
pub mod scenario;
pub mod servo;
