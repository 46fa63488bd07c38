//! The core's parts of the methods that are there for comparison.

use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use rivals::{LeastSquaresConfig, MultiStepLeastSquares, Relay};

use super::{BaselineSettings, Scenario};

impl Scenario {
    /// What a recursive least squares is built from.
    #[must_use]
    pub fn least_squares(&self, settings: &BaselineSettings) -> LeastSquaresConfig {
        LeastSquaresConfig {
            cutoff: settings.filter_cutoff,
            forgetting: settings.forgetting,
            a: self.stated.identifier.initial.a.unwrap_or(0.0),
            // Out of every range: it is refused by its key.
            b: self.stated.identifier.initial.b.unwrap_or(f64::NAN),
        }
    }

    /// The relay, its level within what the amplifier can do.
    ///
    /// # Errors
    /// The level must be above zero.
    pub fn relay<N: Number>(
        &self,
        level: f64,
        settings: &BaselineSettings,
    ) -> Result<Relay<N>, OutOfRange> {
        let [low, high] = self.controller().limit;
        let level = level.min(high).min(-low);
        let delay = (settings.relay_delay / self.sample_time()).round();
        Relay::new(level, delay as u32)
    }

    /// The multi-step recursion, its block a whole number of samples.
    ///
    /// # Errors
    /// The parameter out of its range.
    pub fn multi_step<N: Number>(
        &self,
        settings: &BaselineSettings,
    ) -> Result<MultiStepLeastSquares<N>, OutOfRange> {
        let units = &self.units();
        let block = (settings.block / units.sample_time()).round().max(1.0) as u32;
        MultiStepLeastSquares::new(units, block, &self.least_squares(settings))
    }
}
