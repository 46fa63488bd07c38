//! The parts of the methods to compare with.

use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use rivals::{LeastSquaresConfig, MultiStepLeastSquares, Relay};

use super::Scenario;

impl Scenario {
    /// The settings of a recursive least squares.
    #[must_use]
    pub fn least_squares(&self) -> LeastSquaresConfig {
        let settings = &self.identifier.rival;
        LeastSquaresConfig {
            cutoff: settings.filter_cutoff,
            forgetting: settings.forgetting,
            a: self.stated.identifier.initial.a.unwrap_or(0.0),
            // Out of every range: it is refused by its key.
            b: self.stated.identifier.initial.b.unwrap_or(f64::NAN),
        }
    }

    /// A relay of a level within the amplifier's limit and a delay, s.
    ///
    /// # Errors
    /// The level must be above zero.
    pub fn relay<N: Number>(&self, level: f64, delay: f64) -> Result<Relay<N>, OutOfRange> {
        let [low, high] = self.controller().limit;
        let level = level.min(high).min(-low);
        let delay = (delay / self.sample_time()).round();
        Relay::new(level, delay as u32)
    }

    /// The multi-step recursion, its block a whole number of samples.
    ///
    /// # Errors
    /// The parameter out of its range.
    pub fn multi_step<N: Number>(&self) -> Result<MultiStepLeastSquares<N>, OutOfRange> {
        let units = &self.units();
        let block = (self.identifier.rival.block / units.sample_time())
            .round()
            .max(1.0) as u32;
        MultiStepLeastSquares::new(units, block, &self.least_squares())
    }
}
