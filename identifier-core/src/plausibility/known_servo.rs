use super::PlausibilitySettings;
use super::model::Model;
use super::motion::{Able, Motion};
use super::readings::Readings;
use super::response::Known;
use crate::number::Number;
use crate::parameters::IdentifiedServo;

/// What a watch needs of a servo that was identified, in the units of its loop: computed in f64, so
/// prepared where there is time for that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownServo<N> {
    /// By how many counts an increment may differ from the one before.
    pub(super) change: N,
    pub(super) able: Able<N>,
    pub(super) response: Known<N>,
    /// Whole samples from a command until it acts, and the part of a sample beyond them.
    pub(super) delay: usize,
    pub(super) part: N,
}

/// Samples that a command may take until it acts.
pub(super) const LONGEST_DELAY: usize = 16;

impl<N: Number> KnownServo<N> {
    /// Of an axis with these settings; none if they are not allowed, or the servo has no gain to speak of.
    #[must_use]
    pub fn of(settings: &PlausibilitySettings, servo: &IdentifiedServo) -> Option<Self> {
        let units = settings.check().ok()?;
        let model = Model::of(servo, settings, &units, LONGEST_DELAY - 2)?;
        Some(Self {
            change: Readings::change_of(&model),
            able: Motion::able(&model, settings, units.sample_time()),
            response: Known::new(&model),
            delay: model.delay,
            part: N::from_f64(model.part),
        })
    }
}
