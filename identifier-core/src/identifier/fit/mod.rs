//! Fits of the servo's parameters to a record of its motion and its command.
//!
//! The work is shared between an interrupt and the background, and neither waits for the other: the
//! interrupt's [`Recorder`] condenses samples to [`NumberedBlock`]s, which go through a queue, and the
//! background's [`Fits`] collect them in a record of their own and fit to it.

mod block;
mod fit_result;
mod fits;
mod fitter;
mod pass;
mod record;
mod recorder;
mod start;
mod survey;
mod trial;

pub(crate) use block::Blocking;
pub use block::NumberedBlock;
pub(crate) use fit_result::FitResult;
pub(crate) use fits::{Ended, Fits};
pub(crate) use fitter::{Fitter, FitterConfig, Prior};
pub(crate) use recorder::Recorder;

/// The unknowns of a fit: a, b, c, d, then the model's position and velocity at the start.
const UNKNOWNS: usize = 6;

/// Places of the unknowns.
const A: usize = 0;
const B: usize = 1;
const COULOMB: usize = 2;
const POSITION: usize = 4;
const VELOCITY: usize = 5;

/// Variance of a count's rounding.
pub(crate) const ROUNDING: f64 = 1.0 / 12.0;
