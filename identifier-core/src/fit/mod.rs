//! Fits of the servo's parameters to a record of its motion and its command.
//!
//! The work is shared between an interrupt and the background, and neither waits for the other. The interrupt's
//! [`Recorder`] condenses samples to [`NumberedBlock`]s, which pass through a queue. The background collects them in a
//! record, [`Blocks`], and fits to it. The identifiers do this for a servo that runs. A caller does it for a short
//! motion from rest ([`Fitter::from_rest`]).
//!
//! Positions are in counts, times in samples and commands in command units, unless something else is stated.

pub(crate) mod autocorrelation;
pub(crate) mod block;
mod block_pass;
mod command;
mod early;
mod errors;
mod fit_result;
mod fitter;
mod gain;
mod late;
mod levenberg_marquardt;
mod pass;
mod prediction;
mod prior;
mod record;
mod recorder;
mod start;
mod statistics;

pub(crate) use block::NumberedBlock;
pub use block::{Block, Blocking};
pub(crate) use early::EarlyCommand;
pub use fit_result::FitResult;
pub use fitter::{Fit, Fitter};
pub use levenberg_marquardt::{Descent, DescentSettings, DescentStep, Explanation};
pub(crate) use prior::{FitterConfig, Prior};
pub use record::Blocks;
pub(crate) use record::Record;
pub use recorder::Recorder;

use crate::parameters::Unknown;

/// Places of the first unknowns of every set.
const A: usize = 0;
const B: usize = 1;

/// Variance of a count's rounding, counts².
pub const QUANTISATION_VARIANCE: f64 = 1.0 / 12.0;

/// The place of an unknown among those of a fit without terms; none for the size of a term.
#[inline(always)]
pub(crate) fn place_of(unknown: Unknown) -> Option<usize> {
    unknown.parameter().map(|parameter| parameter as usize)
}
