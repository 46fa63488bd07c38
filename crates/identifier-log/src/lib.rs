//! Identification of servos from recorded logs: file, columns, samples, fit, verdict, gains.
//!
//! ```
//! use identifier_log::identify;
//! use identifier_log::log::{Log, Table};
//! use identifier_log::recognise::{LogOptions, recognise};
//! use identifier_log::tune::Tuned;
//!
//! # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../host-sim/logs/simulated-servo.csv.gz");
//! let table = Table::read(path.as_ref())?;
//! let options = recognise(&table, &LogOptions::default())?.options()?;
//! let log = Log::new(&table, &options.log_columns(), options.log_sample_time())?;
//! let found = identify(&[log], &[], &options, &|| true)?;
//! let (tuned, _) = Tuned::stiffest(&found.options, &found.summary)?;
//! println!("{}: b = {}", found.summary.reason, found.summary.estimates.b.value);
//! println!("kp = {}, kd = {}, ki = {}", tuned.tuning.kp, tuned.tuning.kd, tuned.tuning.ki);
//! # assert!((found.summary.estimates.b.value / 257.7 - 1.0).abs() < 0.02 && tuned.tuning.kp > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What the log does not show is a [question](recognise::Question), which [`LogOptions`](recognise::LogOptions) answer.
//! A scenario states more: [`Options::parse`](scenario::Options::parse).
//!
//! | what | where |
//! |---|---|
//! | a log: table of columns, samples in SI and even time | [`log`] |
//! | its columns and units, found or asked for | [`recognise`] |
//! | its settings, and the table of their keys | [`scenario`] |
//! | the fit of all samples, in SI; what the residuals show | [`analysis`], on the crate `log-fit` |
//! | known, bounded or unknown, and why | [`verdict`] |
//! | results, which are the JSON; their physical units; their origin | [`result`](mod@result), [`physical`], [`provenance`] |
//! | prediction of other logs; gains and forms of a drive's firmware | [`predict`], [`tune`] |

pub mod analysis;
mod column_reading;
pub mod experiment;
mod found_servo;
mod identify;
pub mod log;
mod motion_unit;
pub mod nearest;
mod of_origin;
mod options;
pub mod physical;
pub mod predict;
mod predictions;
pub mod provenance;
mod readings;
pub mod recognise;
pub mod replay;
pub mod result;
mod scaled_recording;
pub mod scenario;
pub mod tune;
pub mod verdict;

pub use found_servo::FoundServo;
pub use identify::{Identified, RecordedSamples, identify, identify_run};
pub use motion_unit::{AxisKind, MotionUnit, UnstatedUnit};
pub use predictions::{Predictions, predict_logs};
