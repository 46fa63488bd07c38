//! The simulator of the servo identifier.

pub mod analysis;
pub mod cli;
pub mod commission;
pub mod compare;
pub mod drift;
pub mod drive;
pub mod experiment;
pub mod live;
pub mod loops;
pub mod monitor;
pub mod paper;
pub mod pil;
pub mod port;
pub mod prediction;
pub mod replay;
pub mod report;
pub mod scenario;
pub mod simulate;
pub mod simulated_drive;
pub mod sweep;
pub mod tune;

/// The version of this program, with the commit that a release was built from where it is known.
pub const VERSION: &str = env!("HOST_SIM_VERSION");
