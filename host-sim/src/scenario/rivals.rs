//! The parts of the method to compare with.

use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use rivals::{LeastSquaresConfig, Relay};

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

    /// The paper's relay, within the amplifier's limit.
    ///
    /// # Errors
    /// The level must be above zero.
    pub fn relay<N: Number>(&self) -> Result<Relay<N>, OutOfRange> {
        let [low, high] = self.controller().limit;
        let level = self.identifier.rival.relay.min(high).min(-low);
        Relay::new(level)
    }
}
