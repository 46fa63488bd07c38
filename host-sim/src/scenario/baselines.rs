//! The core's parts of the methods that are there for comparison.

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::number::Number;
use rivals::{
    ClosedLoopArx, FilteredLeastSquares, LeastSquaresConfig, MechanicalLeastSquares,
    MultiStepLeastSquares, Relay, StateVariableFilter,
};

use super::{Baseline, BaselineSettings, Law, Scenario};

impl Scenario {
    /// The settings of the baseline that the scenario's law is; the defaults if it is none.
    #[must_use]
    pub fn baseline_settings(&self, baseline: Baseline) -> BaselineSettings {
        match &self.identifier.law {
            Law::Baseline(_, settings) => *settings,
            _ => BaselineSettings::of(baseline),
        }
    }

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

    /// Builds every part of a baseline once, so that nothing can fail after output has begun.
    pub(super) fn try_baseline(&self, baseline: Baseline) -> Result<(), OutOfRange> {
        let units = &self.units();
        let settings = self.baseline_settings(baseline);
        let config = self.least_squares(&settings);
        Allowed::Above(0.0).check("initial.b", config.b)?;
        match baseline {
            Baseline::RelayLeastSquares => {
                self.relay::<f64>(settings.relay, &settings)?;
                FilteredLeastSquares::<f64>::new(units, &config).map(|_| ())
            }
            Baseline::RelayCycle | Baseline::TwoRelays => {
                self.relay::<f64>(settings.relay, &settings).map(|_| ())
            }
            Baseline::ProportionalLeastSquares | Baseline::TwoDegreesOfFreedom => {
                StateVariableFilter::<f64>::new(units, settings.filter_cutoff).map(|_| ())
            }
            Baseline::MultiStepLeastSquares => self.multi_step::<f64>(&settings).map(|_| ()),
            Baseline::ClosedLoopArx => ClosedLoopArx::<f64>::new(units, &config).map(|_| ()),
            Baseline::MechanicalLeastSquares => {
                MechanicalLeastSquares::<f64>::new(units, &config).map(|_| ())
            }
        }
    }
}
