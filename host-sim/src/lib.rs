//! The simulator of the servo identifier.

pub mod cli;
pub mod compare;
pub mod drift;
pub mod experiment;
pub mod paper;
pub mod pil;
pub mod replay;
pub mod report;
pub mod scenario;
pub mod sweep;
