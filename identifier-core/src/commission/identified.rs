use super::{CommissionSettings, IdentifiedServo, RoughModel};
use crate::number::Number;
use crate::plausibility::KnownServo;

/// A servo that was identified, and what the interrupt's half needs of it in machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identified<N> {
    /// The servo, SI.
    pub servo: IdentifiedServo,
    pub(super) crude: RoughModel<N>,
    /// Samples from a command to its acceleration.
    pub(super) delay: N,
    /// For the watch over it.
    pub(super) known: Option<KnownServo<N>>,
}

impl<N: Number> Identified<N> {
    pub(super) fn of(servo: &IdentifiedServo, settings: &CommissionSettings) -> Self {
        let CommissionSettings {
            sample_time,
            resolution,
            ..
        } = *settings;
        Self {
            servo: *servo,
            crude: RoughModel::of(&servo.parameters, sample_time, resolution),
            delay: N::from_f64(servo.delay / sample_time),
            known: KnownServo::of(&settings.plausibility(), servo),
        }
    }
}
