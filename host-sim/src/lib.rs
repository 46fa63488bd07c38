//! Simulation and comparison of the identification of servos.
//!
//! A [`scenario`] describes a servo, its loop and an identifier. [`identify_run`] runs it on an exact simulated servo,
//! [`identify_logs`] over recorded logs. Both give every [`Sample`](identifier_log::experiment::Sample) to an observer.
//! A fit to a whole log is that of the crate [`identifier_log`]; the recursive laws run here.
//!
//! ```
//! use host_sim::identify_run;
//! use host_sim::scenario::{Purpose, Scenario};
//!
//! let text = "[plant]\na = 0.5\nb = 180.0\nload = 12.0\n[run]\nduration = 10.0\n";
//! let scenario = Scenario::parse("axis.toml", text, Purpose::Run)?;
//! let summary = identify_run(scenario, &|| true, &mut |_, _| ())?.summary;
//! println!("{}: b = {}", summary.reason, summary.estimates.b.value);
//! # assert!((summary.estimates.b.value / 180.0 - 1.0).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | where |
//! |---|---|
//! | the identifier itself | the crate `identifier-core` |
//! | columns, fit, verdict, results, gains | the crate `identifier-log` |
//! | experiments: one servo, logs, every method, random servos, number formats | [`simulate`], [`replay`], [`compare`], [`sweep`], [`drift`] |
//! | commissioning | [`commission`] |

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
mod virtual_axis;

pub use identify::{IdentifiedScenario, identify_logs, identify_run};
