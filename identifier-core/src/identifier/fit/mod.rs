//! Fits of the servo's parameters to a record of what it did and what was asked of it.

mod fitter;
mod found;
mod pass;
mod record;
mod start;
mod survey;
mod trial;

pub(crate) use fitter::{Fit, Fitter, FitterConfig, Prior};
pub(crate) use found::Found;
pub use record::{Block, Blocking, Record};

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
