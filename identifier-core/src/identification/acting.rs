//! What acts on the servo over a part of a sample, and the acceleration by a unit of each effect.

use super::front_end::{FrontEnd, Part};
use super::waves::Waves;
use super::{Column, Effect, Record, Values};

/// The least relative friction by which is divided.
pub(super) const MIN_DRIFT: f64 = 1e-3;

/// The servo and the commands that act over a part of a sample.
pub(super) struct Acting<'a> {
    pub(super) values: &'a Values,
    pub(super) front_end: &'a FrontEnd,
    pub(super) part: &'a Part,
    pub(super) motion: (usize, usize),
    pub(super) sample: usize,
    pub(super) record: &'a Record<'a>,
    pub(super) waves: &'a Waves,
    pub(super) length: f64,
    /// Gain, and the acceleration by the command.
    pub(super) gain: f64,
    pub(super) drive: f64,
    /// The mean size of that acceleration.
    pub(super) effort: f64,
    /// Acceleration but for friction.
    pub(super) push: f64,
    /// Coulomb friction with that which grows with the load.
    pub(super) coulomb: f64,
    /// Relative friction at this time.
    pub(super) drift: f64,
    /// Reciprocal of the relative inertia.
    pub(super) ease: f64,
    /// Relative friction over relative inertia.
    pub(super) friction: f64,
    /// Change of the relative inertia over the sample.
    pub(super) inertia_change: f64,
    /// Reciprocal of the ripple of the gain.
    pub(super) per_ripple: f64,
    /// The time that has passed, −½ to ½ of the record.
    pub(super) passed: f64,
}

/// Friction and motion over a piece of a sample.
pub(super) struct Shape {
    pub(super) direction: f64,
    pub(super) bell: f64,
    pub(super) low_speed: f64,
    pub(super) middle: f64,
    pub(super) fading: f64,
    pub(super) acceleration: f64,
}

impl Acting<'_> {
    /// The change of the relative inertia over the sample per unit of a column of it.
    #[inline]
    pub(super) fn inertia_change_per(&self, column: &Column) -> f64 {
        let order = match column.setting {
            order if order > 0.0 => order,
            _ => self.values.inertia_order,
        };
        let change = self.record.wave_change(self.motion, self.sample, order);
        change[usize::from(column.effect == Effect::InertiaCosine)]
    }

    /// The acceleration per unit of a column, `shaped` being the derivative of the command.
    #[inline]
    pub(super) fn forcing(&self, column: &Column, shape: &Shape, shaped: f64) -> f64 {
        // At the column's order where it has one, else at the model's.
        let wave_of = |own: f64| {
            let order = if column.setting > 0.0 {
                column.setting
            } else {
                own
            };
            let known = self.waves.get(order);
            known.unwrap_or_else(|| self.record.wave(self.sample, order))
        };
        // Of a push by the command friction that grows with the load takes a part.
        let slowing = self.values.get(Effect::LoadFriction) * self.drift * shape.direction;
        let kept = 1.0 - slowing * self.drive.signum();
        let driven = self.drive - slowing * self.effort;
        match column.effect {
            Effect::B => driven / self.values.get(Effect::B),
            Effect::Coulomb => -shape.direction * self.friction,
            Effect::Load => self.ease,
            Effect::Delay => -kept * self.gain * self.part.slope,
            Effect::CurrentLoop => kept * self.gain * self.part.per_lag,
            Effect::LowSpeed => {
                let bell = if column.setting > 0.0 {
                    let ratio = shape.middle / column.setting;
                    libm::exp(-ratio * ratio)
                } else {
                    shape.bell
                };
                -shape.direction * bell * self.friction
            }
            Effect::LowSpeedVelocity => {
                let ratio = shape.middle / shape.fading.max(f64::MIN_POSITIVE);
                -shape.low_speed * shape.bell * 2.0 * ratio * ratio
                    / shape.fading.max(f64::MIN_POSITIVE)
                    * shape.direction
            }
            Effect::GravitySine => wave_of(1.0)[0] * self.ease,
            Effect::GravityCosine => wave_of(1.0)[1] * self.ease,
            Effect::RippleSine => wave_of(self.values.order)[0] * self.ease,
            Effect::RippleCosine => wave_of(self.values.order)[1] * self.ease,
            Effect::DeadBand | Effect::GainAsymmetry | Effect::LimitSlope | Effect::HiddenLimit => {
                kept * self.gain * shaped
            }
            Effect::LoadFriction => -self.effort * self.drift * shape.direction,
            Effect::GainDrift => {
                let drift = self.values.get(Effect::GainDrift) * self.passed;
                driven * self.passed / (1.0 + drift)
            }
            Effect::FrictionDrift => {
                let friction = self.coulomb + shape.low_speed * shape.bell;
                -shape.direction * friction * self.passed / self.drift.max(MIN_DRIFT)
            }
            Effect::TorqueRippleSine => {
                driven * self.per_ripple * wave_of(self.values.gain_order)[0]
            }
            Effect::TorqueRippleCosine => {
                driven * self.per_ripple * wave_of(self.values.gain_order)[1]
            }
            Effect::InertiaSine => {
                -shape.acceleration * self.ease * wave_of(self.values.inertia_order)[0]
            }
            Effect::InertiaCosine => {
                -shape.acceleration * self.ease * wave_of(self.values.inertia_order)[1]
            }
            Effect::A
            | Effect::Asymmetry
            | Effect::Quadratic
            | Effect::Compliance
            | Effect::Play => 0.0,
        }
    }
}
