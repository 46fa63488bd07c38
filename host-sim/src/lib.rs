//! Simulation, replay and comparison of the identification of servos.
//!
//! A [`scenario`] describes a servo, its loop and an identifier. [`simulate`] runs it on an exact simulated servo,
//! [`replay`] on recorded logs. Both give every [`experiment::Sample`] to an observer. [`analysis`] makes estimates
//! with standard errors and a verdict of them. [`recognise`] finds the columns of a log.
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
//! | results, which are the JSON; their physical units | [`result`], [`physical`] |

pub mod analysis;
#[cfg(feature = "experiments")]
pub mod commission;
#[cfg(feature = "experiments")]
pub mod compare;
#[cfg(feature = "experiments")]
pub mod drift;
mod identify;
pub mod loops;
pub mod replay;
pub mod result;
pub mod scenario;
pub mod simulate;
#[cfg(feature = "experiments")]
pub mod sweep;

pub use identify::{Found, identify_logs, identify_run};
