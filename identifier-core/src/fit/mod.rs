//! Fits of the servo's parameters to a record of its motion and its command.
//!
//! The work is shared between an interrupt and the background, and neither waits for the other: the
//! interrupt's [`Recorder`] condenses samples to [`NumberedBlock`]s, which go through a queue, and the
//! background's [`Fits`] collect them in a record of their own and fit to it.

mod block;
pub(crate) mod colour;
mod command;
mod early;
mod fit_result;
mod fits;
mod fitter;
mod gain;
mod late;
pub(crate) mod levenberg_marquardt;
mod pass;
mod prediction;
mod prior;
mod record;
mod recorder;
mod start;
mod survey;
mod wait;

pub use block::NumberedBlock;
pub(crate) use block::{Block, Blocking};
pub(crate) use command::late_commands;
pub(crate) use early::EarlyCommand;
pub(crate) use fit_result::FitResult;
pub(crate) use fits::Fits;
pub(crate) use fitter::{Fit, Fitter};
pub(crate) use prediction::Predicted;
pub(crate) use prior::{FitterConfig, Prior};
pub(crate) use record::Blocks;
pub(crate) use recorder::Recorder;
pub(crate) use wait::PATIENCE;

use crate::parameters::Unknown;

/// Places of the first unknowns of every set.
const A: usize = 0;
const B: usize = 1;

/// Variance of a count's rounding.
pub(crate) const ROUNDING: f64 = 1.0 / 12.0;

/// The place of an unknown among those of a fit without terms; none for the size of a term.
pub(crate) fn place_of(unknown: Unknown) -> Option<usize> {
    unknown.parameter().map(|parameter| parameter as usize)
}
