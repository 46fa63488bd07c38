//! Identification from a record by one fit. It needs no first guess, no setting of the noise and no choice of a
//! bandwidth.
//!
//! The recorded command drives the servo's model, and a Kalman filter keeps it with the recorded position. Levenberg
//! and Marquardt's search minimizes its innovations ([`RecordFitter::search`]). The noise is the innovations' scale, and the
//! start is [found elsewhere](crate::Recording::scales). The model is trusted over the horizon at
//! which the estimates scatter least ([`RecordFitter::best_horizon`]).
//!
//! Prediction errors and the search for their minimum: Ljung, System Identification, 2nd edition 1999, sections 3.2,
//! 7.2 and 10.2.

mod acting;
mod coupling;
mod effect;
mod fitter;
mod front_end;
mod gain;
mod horizons;
mod lateness;
mod pass;
mod record;
mod repetition;
mod search;
mod spectrum;
mod state;
mod statistics;
mod sums;
mod twisting;
mod waves;

pub use effect::{Column, Effect, Values};
pub use fitter::{GoesOn, RecordFitter};
pub(crate) use front_end::acting_commands;
pub use gain::Horizon;
pub use lateness::Lateness;
pub use pass::{MAX_COLUMNS, ModelPass, Row};
pub use record::Record;
pub use search::{Fitted, Search};
pub use spectrum::{MAX_UNKNOWNS, Matrix, Spectrum, Vector};
pub use statistics::RecordStatistics;
pub use sums::{Covariances, Sums, segments};

/// Standard deviation of a count's rounding, counts.
pub const QUANTISATION_SIGMA: f64 = 0.288_675;

#[cfg(test)]
mod tests;
