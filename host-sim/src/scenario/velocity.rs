//! The velocity estimate, chosen at run time.

use identifier_core::error::OutOfRange;
use identifier_core::measurement::velocity::{
    AveragedDifference, BackwardDifference, LowPass, VelocityEstimate,
};
use identifier_core::number::Number;
use identifier_core::units::Units;

use super::VelocitySettings;

/// A computation that works with any velocity estimate; the scenario says with which.
pub trait WithVelocity<N: Number> {
    /// Its result.
    type Output;

    /// Does it.
    fn with<V: VelocityEstimate<N> + 'static>(self, velocity: V) -> Self::Output;
}

impl VelocitySettings {
    /// Does a computation with the estimate of these settings.
    ///
    /// # Errors
    /// A cut-off outside its range.
    pub fn with<N: Number, W: WithVelocity<N>>(
        &self,
        units: &Units,
        work: W,
    ) -> Result<W::Output, OutOfRange> {
        Ok(match *self {
            Self::LowPass(cutoff) => work.with(LowPass::new(units, cutoff)?),
            Self::Difference => work.with(BackwardDifference),
            Self::AveragedDifference => work.with(AveragedDifference::new()),
        })
    }
}
