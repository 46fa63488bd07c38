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
//! println!("{}: b = {}", summary.reason, summary.estimates.b.value);
//! # assert!((summary.estimates.b.value / 180.0 - 1.0).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | where |
//! |---|---|
//! | the identifier itself | the crate `identifier-core` |
//! | experiments: one servo, logs, every method, random servos, number formats | [`simulate`], [`replay`], [`compare`], [`sweep`], [`drift`] |
//! | commissioning and gains | [`commission`], [`tune`] |
//! | the host of a drive | [`drive`], [`port`] |
//! | results, which are the JSON; their physical units | [`result`], [`physical`] |
//! | pages, tables, pictures; CSV | [`present`], [`render`]; [`csv`] |
//! | verbs, options, outputs | [`cli`] |

#![cfg_attr(
    not(feature = "program"),
    allow(
        dead_code,
        unused_imports,
        unused_variables,
        reason = "what only the program needs stays where it belongs; the linker leaves it out"
    )
)]

pub mod analysis;
#[cfg(feature = "program")]
pub mod cli;
#[cfg(feature = "experiments")]
pub mod commission;
#[cfg(feature = "experiments")]
pub mod compare;
#[cfg(feature = "program")]
pub mod csv;
#[cfg(feature = "experiments")]
pub mod drift;
#[cfg(feature = "program")]
pub mod drive;
pub mod experiment;
#[cfg(feature = "experiments")]
pub mod export;
pub mod gone;
#[cfg(feature = "program")]
pub mod init;
pub mod log;
pub mod loops;
#[cfg(feature = "program")]
pub mod monitor;
pub mod nearest;
#[cfg(feature = "program")]
pub mod paper;
pub mod physical;
#[cfg(feature = "program")]
pub mod port;
pub mod predict;
#[cfg(feature = "program")]
pub mod present;
pub mod program;
#[cfg(feature = "experiments")]
pub mod provenance;
pub mod recognise;
#[cfg(feature = "program")]
pub mod render;
pub mod replay;
pub mod result;
pub mod scan;
pub mod scenario;
pub mod simulate;
#[cfg(feature = "program")]
pub mod simulated_drive;
#[cfg(feature = "experiments")]
pub mod sweep;
pub mod tune;
pub mod verdict;

pub use program::VERSION;
