//! The simulator of the servo identifier.

pub mod analysis;
pub mod cli;
pub mod commission;
pub mod compare;
pub mod drift;
pub mod drive;
pub mod experiment;
pub mod loops;
pub mod nearest;
pub mod paper;
pub mod pil;
pub mod port;
pub mod prediction;
pub mod program;
pub mod replay;
pub mod report;
pub mod scenario;
pub mod simulate;
pub mod sweep;
pub mod tune;
