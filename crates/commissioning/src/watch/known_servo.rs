//! A servo that was identified, in the units of the loop.

use super::WatchSettings;
use super::model::Model;
use super::readings::Readings;
use super::response::Known;
use super::standstill::{AccelerationLimits, StandstillWatch};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;

/// The data of an identified servo that a watch needs, in the units of its loop. They are computed in f64, outside
/// the interrupt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownServo<N> {
    /// By how many counts an increment may differ from the one before.
    pub(super) change: N,
    pub(super) able: AccelerationLimits<N>,
    pub(super) response: Known<N>,
    /// Whole samples from a command until it acts, and the part of a sample beyond them.
    pub(super) delay: usize,
    pub(super) part: N,
}

/// Samples that a command may take until it acts.
pub(super) const MAX_DELAY_SAMPLES: usize = 16;

impl<N: Number> KnownServo<N> {
    /// For an axis with these settings. None if they are not allowed, or the gain of the servo is practically zero.
    #[must_use]
    pub fn from_identified(settings: &WatchSettings, servo: &IdentifiedServo) -> Option<Self> {
        let units = settings.check().ok()?;
        let model = Model::from_identified(servo, settings, &units, MAX_DELAY_SAMPLES - 2)?;
        let range = settings.used_for.gain_range();
        let lightest = model.with_gain(range);
        Some(Self {
            change: Readings::change_of(&lightest),
            able: StandstillWatch::able(&model, settings, units.sample_time())
                .with_braking_of(&lightest),
            response: Known::new(&model.with_gain(1.0 / range)),
            delay: model.delay,
            part: N::from_f64(model.part),
        })
    }

    /// The same with a load that this command balances.
    pub(crate) fn with_holding_of(self, command: N) -> Self {
        Self {
            able: self.able.with_holding_of(command),
            response: self.response.with_holding_of(command),
            ..self
        }
    }

    /// The same for the motor of two masses whose load has β times its inertia. Until the spring moves the load, the
    /// gain of the motor is 1 + β times as large.
    pub(crate) fn with_load_on_a_spring(self, ratio: f64) -> Self {
        Self {
            change: N::from_f64(1.0 + ratio) * self.change,
            ..self
        }
    }
}
