//! An identified servo in the units of the loop.

use super::{Plausibility, PlausibilitySettings};
use crate::parameters::IdentifiedServo;
use crate::units::Units;

/// What a servo may have more of a parameter than its model.
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
    /// What a load may step by, counts a sample squared.
    pub(super) load_step: f64,
    /// What friction and load may brake by, after such a step.
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
    /// None if the servo has no gain to speak of.
    pub(super) fn of(
        servo: &IdentifiedServo,
        settings: &PlausibilitySettings,
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
        let load_step = Plausibility::<f64>::LOAD_STEP * gain * settings.limit();
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
