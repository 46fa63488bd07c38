//! The program `servo-id`: verbs over the experiments of [`host_sim`], the presentation of their results, and the host
//! of a drive.
//!
//! | what | where |
//! |---|---|
//! | the experiments, their scenarios and results | the crate [`host_sim`] |
//! | the paper's experiment | [`paper`] |
//! | robot models and firmware from results | [`export`] |
//! | pages, tables, pictures; CSV | [`present`], [`render`]; [`csv`] |
//! | the host of a drive, and a drive without hardware | [`drive`], [`port`]; [`simulated_drive`] |
//! | verbs, options, outputs | [`cli`] |

#[cfg(feature = "program")]
pub mod cli;
#[cfg(feature = "pages")]
pub mod csv;
#[cfg(feature = "drive")]
pub mod drive;
pub mod export;
#[cfg(feature = "operation")]
pub mod monitor;
#[cfg(feature = "pages")]
pub mod paper;
#[cfg(feature = "drive")]
pub mod port;
#[cfg(feature = "pages")]
pub mod present;
pub mod program;
#[cfg(feature = "pages")]
pub mod render;
#[cfg(all(test, feature = "drive"))]
#[path = "tests/scripted_line.rs"]
mod scripted_line;
#[cfg(feature = "operation")]
pub mod simulated_drive;

pub use program::VERSION;

/// Standard errors to each side of an estimate that contain the true value in 95 % of cases.
pub(crate) const SIDES: f64 = 2.0;
