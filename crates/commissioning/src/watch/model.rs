//! The model of an identified servo, in the units of its loop.

use super::WatchSettings;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::units::Units;

/// The share of the command limit by which a load may step without being a fault.
pub(super) const LOAD_STEP: f64 = 0.3;

/// Largest ratio of a servo's parameter to its model's.
pub(super) const MODEL_ERROR: f64 = 1.2;

/// Friction at low speed over Coulomb friction, to which Stribeck's may add a half.
pub(crate) const LOW_SPEED: f64 = 1.5;

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
    pub(super) fn with_gain(&self, factor: f64) -> Self {
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
        let load_step = LOAD_STEP * gain * settings.limit();
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
