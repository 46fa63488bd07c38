//! A servo that was identified, in the units of the loop.

use super::readings::Readings;
use super::response::Known;
use super::standstill::{Able, StandstillWatch};
use super::{ServoWatch, WatchSettings};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::units::Units;

/// The data of an identified servo that a watch needs, in the units of its loop: computed in f64, so
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
pub(super) const MAX_DELAY_SAMPLES: usize = 16;

impl<N: Number> KnownServo<N> {
    /// Of an axis with these settings; none if they are not allowed, or the servo has no gain to speak of.
    #[must_use]
    pub fn from_identified(settings: &WatchSettings, servo: &IdentifiedServo) -> Option<Self> {
        let units = settings.check().ok()?;
        let model = Model::from_identified(servo, settings, &units, MAX_DELAY_SAMPLES - 2)?;
        let range = settings.used_for.gain_range();
        let lightest = model.with_gain(range);
        Some(Self {
            change: Readings::change_of(&lightest),
            able: StandstillWatch::able(&model, settings, units.sample_time()).braked_by(&lightest),
            response: Known::new(&model.with_gain(1.0 / range)),
            delay: model.delay,
            part: N::from_f64(model.part),
        })
    }

    /// The same with a load that this command balances.
    pub(crate) fn holding_by(self, command: N) -> Self {
        Self {
            able: self.able.holding_by(command),
            response: self.response.holding_by(command),
            ..self
        }
    }

    /// The same as the motor of two masses, whose load has β of its inertia: before the spring has turned the load, the motor
    /// is stronger by 1 + β.
    pub(crate) fn with_load_on_a_spring(self, ratio: f64) -> Self {
        Self {
            change: N::from_f64(1.0 + ratio) * self.change,
            ..self
        }
    }
}

/// Largest ratio of a servo's parameter to its model's.
pub(super) const MODEL_ERROR: f64 = 1.2;

/// Position in counts, time in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Model {
    /// b.
    pub(super) gain: f64,
    /// a.
    pub(super) x: f64,
    /// c.
    pub(super) coulomb: f64,
    /// d.
    pub(super) load: f64,
    /// c over b, command units.
    pub(super) breakaway: f64,
    /// Largest step of a load, counts a sample squared.
    pub(super) load_step: f64,
    /// Largest braking by friction and load, after such a step.
    pub(super) braking: f64,
    /// The largest acceleration, after such a step.
    pub(super) most_acceleration: f64,
    /// Whole samples from a command until it acts, and the part of a sample beyond them.
    pub(super) delay: usize,
    pub(super) part: f64,
    /// Standard deviation of the position, counts.
    pub(super) unexplained: f64,
}

impl Model {
    /// The same servo with another inertia, by which b and all accelerations are larger.
    fn with_gain(&self, factor: f64) -> Self {
        Self {
            gain: factor * self.gain,
            coulomb: factor * self.coulomb,
            load: factor * self.load,
            load_step: factor * self.load_step,
            braking: factor * self.braking,
            most_acceleration: factor * self.most_acceleration,
            x: factor * self.x,
            ..*self
        }
    }

    /// None if the servo has no gain to speak of.
    pub(super) fn from_identified(
        servo: &IdentifiedServo,
        settings: &WatchSettings,
        units: &Units,
        longest_delay: usize,
    ) -> Option<Self> {
        let parameters = &servo.parameters;
        let acceleration = units.acceleration();
        let gain = parameters.b * acceleration;
        let usable = gain.is_normal() && gain > 0.0 && parameters.a.is_finite();
        if !usable {
            return None;
        }
        let [least, most] = settings.command;
        let load_step = ServoWatch::<f64>::LOAD_STEP * gain * settings.limit();
        let coulomb = parameters.coulomb.max(0.0) * acceleration;
        let load = parameters.load * acceleration;
        let braking = coulomb + load.abs() + load_step;
        let samples = (servo.delay.max(0.0) / units.sample_time()).min(longest_delay as f64);
        let delay = libm::floor(samples);
        Some(Self {
            gain,
            x: parameters.a * units.rate(),
            coulomb,
            load,
            breakaway: coulomb / gain,
            load_step,
            braking,
            most_acceleration: gain * most.max(-least) + braking,
            delay: delay as usize,
            part: samples - delay,
            unexplained: servo.unexplained * units.position(),
        })
    }
}
