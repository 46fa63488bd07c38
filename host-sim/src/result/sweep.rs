//! The result of a sweep.

use serde::Serialize;

use crate::sweep::Distribution;

/// The result of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepResult {
    /// The law's name.
    pub law: &'static str,
    /// The seed of servos and references.
    pub seed: u32,
    /// Servos that were asked for.
    pub wanted: u32,
    /// Distribution over the servos that were run.
    #[serde(flatten)]
    pub distribution: Distribution,
}
