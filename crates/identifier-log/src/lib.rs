//! Identification of servos from recorded logs.

pub mod log;
pub mod nearest;
pub mod physical;
mod readings;
pub mod recognise;
pub mod scenario;
pub mod verdict;
