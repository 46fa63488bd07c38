//! Simulation, replay and comparison of the identification of servos, and the command line `servo-id`.
//!
//! A [`scenario`] describes a servo, its loop and an identifier. [`simulate`] runs it on an exact simulated servo,
//! [`replay`] on recorded logs, which a [`scan`] checks first; both hand every [`experiment::Sample`] to an observer, and
//! [`analysis`] makes estimates with standard errors and a verdict of them.
//!
//! ```
//! use host_sim::analysis::Summariser;
//! use host_sim::scenario::{Purpose, Scenario};
//! use host_sim::simulate;
//!
//! let text = "[plant]\na = 0.5\nb = 180.0\nload = 12.0\n[run]\nduration = 10.0\n";
//! let scenario = Scenario::parse("axis.toml", text, Purpose::Run)?;
//! let mut summariser = Summariser::new(&scenario);
//! let outcome = simulate::run(&scenario, &mut |sample| summariser.add(sample))
//!     .map_err(|fault| fault.to_string())?;
//! let summary = summariser.finish(&scenario, outcome);
//! println!("{}: b = {}", summary.reason, summary.estimates.b.last);
//! # assert!((summary.estimates.b.last / 180.0 - 1.0).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | where |
//! |---|---|
//! | the identifier itself | the crate `identifier-core` |
//! | experiments: one servo, logs, every method, random servos, number formats | [`simulate`], [`replay`], [`compare`], [`sweep`], [`drift`] |
//! | commissioning and gains | [`commission`], [`tune`] |
//! | the host of a drive | [`drive`], [`port`] |
//! | results, which are the JSON | [`result`] |
//! | pages, tables, pictures; CSV | [`present`], [`render`]; [`csv`] |
//! | verbs, options, outputs | [`cli`] |

pub mod analysis;
pub mod check;
pub mod cli;
pub mod commission;
pub mod compare;
pub mod csv;
pub mod drift;
pub mod drive;
pub mod experiment;
pub mod export;
mod identify;
pub mod init;
pub mod live;
pub mod log;
pub mod loops;
pub mod monitor;
pub mod nearest;
pub mod paper;
pub mod port;
pub mod predict;
pub mod present;
pub mod program;
pub mod provenance;
pub mod recognise;
pub mod render;
pub mod replay;
pub mod result;
pub mod scan;
pub mod scenario;
pub mod simulate;
pub mod simulated_drive;
pub mod sweep;
pub mod tune;
pub mod verdict;

pub use program::VERSION;
