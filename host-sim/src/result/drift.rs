//! The result of a comparison of number formats.

use serde::Serialize;

use crate::drift::{Difference, Differences};
use crate::scenario::Arithmetic;

/// Differences of number formats from double precision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DriftResult {
    /// Samples run.
    pub samples: u64,
    /// Sample time, s.
    pub sample_time: f64,
    /// Whether every value was finite.
    pub all_finite: bool,
    /// Differences in single precision.
    pub f32: Vec<Difference>,
    /// Differences in fixed point.
    pub fixed: Vec<Difference>,
}

impl DriftResult {
    /// Of a run.
    #[must_use]
    pub fn new(differences: &Differences, samples: u64, sample_time: f64) -> Self {
        Self {
            samples,
            sample_time,
            all_finite: differences.all_finite(),
            f32: differences.of(Arithmetic::F32),
            fixed: differences.of(Arithmetic::Fixed),
        }
    }
}
