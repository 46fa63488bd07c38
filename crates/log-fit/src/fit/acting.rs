//! The forces on the servo over a part of a sample, and the acceleration by a unit of each effect.

use super::front_end::{FrontEnd, Part};
use super::waves::Waves;
use super::{Column, Effect, Record, Values};

/// The least relative friction by which is divided.
const MIN_DRIFT: f64 = 1e-3;

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
    pub(super) motor_inertia_inverse: f64,
    /// The part of that reciprocal that depends on the angle, and the reciprocal of the motor's share of the inertia.
    pub(super) per_inertia: f64,
    pub(super) per_motor: f64,
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
    /// Viscous friction over inertia.
    pub(super) viscous: f64,
    pub(super) stribeck_factor: f64,
    pub(super) low_speed: f64,
    pub(super) middle: f64,
    pub(super) fading: f64,
    pub(super) acceleration: f64,
    /// The part of it that does not go with the velocity.
    pub(super) pushed: f64,
}

impl Acting<'_> {
    /// The change of the relative inertia over the sample per unit of a column of it.
    #[inline]
    fn inertia_change_per(&self, column: &Column) -> f64 {
        let order = match column.setting {
            order if order > 0.0 => order,
            _ => self.values.inertia_order,
        };
        let change = self.record.wave_change(self.motion, self.sample, order);
        change[usize::from(column.effect == Effect::InertiaCosine)]
    }

    /// The acceleration per unit of each column, and its viscous friction per unit. `shaped` are the derivatives of the
    /// command. It is a loop over slices and no function of a column. The common part of the columns is computed once,
    /// and the loop exists once for any number of columns.
    pub(super) fn force(
        &self,
        columns: &[Column],
        shape: &Shape,
        shaped: &[f64],
        forcing: &mut [f64],
        per_rate: &mut [f64],
    ) {
        // At the column's order where it has one, else at the model's.
        let wave_of = |column: &Column, own: f64| {
            let order = if column.setting > 0.0 {
                column.setting
            } else {
                own
            };
            let known = self.waves.get(order);
            known.unwrap_or_else(|| self.record.wave(self.sample, order))
        };
        // Friction that grows with the load takes a part of the command's force.
        let slowing = self.values.get(Effect::LoadFriction) * self.drift * shape.direction;
        let kept = 1.0 - slowing * self.drive.signum();
        let driven = self.drive - slowing * self.effort;
        let outputs = forcing.iter_mut().zip(per_rate);
        for ((column, shaped), (forcing, per_rate)) in columns.iter().zip(shaped).zip(outputs) {
            *per_rate = 0.0;
            *forcing = match column.effect {
                Effect::A => {
                    *per_rate = self.friction;
                    0.0
                }
                Effect::Asymmetry => {
                    *per_rate = self.friction * shape.direction;
                    0.0
                }
                Effect::Quadratic => {
                    *per_rate = self.friction * shape.middle.abs();
                    0.0
                }
                Effect::B => driven / self.values.get(Effect::B),
                Effect::Coulomb => -shape.direction * self.friction,
                Effect::Load => self.motor_inertia_inverse,
                Effect::Delay => -kept * self.gain * self.part.slope,
                Effect::CurrentLoop => kept * self.gain * self.part.per_lag,
                Effect::LowSpeed => {
                    let stribeck_factor = if column.setting > 0.0 {
                        let ratio = shape.middle / column.setting;
                        libm::exp(-ratio * ratio)
                    } else {
                        shape.stribeck_factor
                    };
                    -shape.direction * stribeck_factor * self.friction
                }
                Effect::LowSpeedVelocity => {
                    let ratio = shape.middle / shape.fading.max(f64::MIN_POSITIVE);
                    -shape.low_speed * shape.stribeck_factor * 2.0 * ratio * ratio
                        / shape.fading.max(f64::MIN_POSITIVE)
                        * shape.direction
                }
                Effect::DeadBand
                | Effect::GainAsymmetry
                | Effect::LimitSlope
                | Effect::HiddenLimit => kept * self.gain * shaped,
                Effect::LoadFriction => -self.effort * self.drift * shape.direction,
                Effect::GainDrift => {
                    let drift = self.values.get(Effect::GainDrift) * self.passed;
                    driven * self.passed / (1.0 + drift)
                }
                Effect::FrictionDrift => {
                    *per_rate = shape.viscous * self.passed / self.drift.max(MIN_DRIFT);
                    let friction = self.coulomb + shape.low_speed * shape.stribeck_factor;
                    -shape.direction * friction * self.passed / self.drift.max(MIN_DRIFT)
                }
                Effect::TorqueRippleSine => {
                    driven * self.per_ripple * wave_of(column, self.values.gain_order)[0]
                }
                Effect::TorqueRippleCosine => {
                    driven * self.per_ripple * wave_of(column, self.values.gain_order)[1]
                }
                Effect::InertiaSine => {
                    *per_rate = 0.5 * self.per_inertia * self.inertia_change_per(column);
                    -shape.acceleration
                        * self.per_inertia
                        * wave_of(column, self.values.inertia_order)[0]
                }
                Effect::InertiaCosine => {
                    *per_rate = 0.5 * self.per_inertia * self.inertia_change_per(column);
                    -shape.acceleration
                        * self.per_inertia
                        * wave_of(column, self.values.inertia_order)[1]
                }
                Effect::LoadShare => {
                    *per_rate = shape.viscous * self.per_motor;
                    shape.pushed * self.per_motor
                }
                force => force.force().map_or(0.0, |[place, part]| {
                    wave_of(column, self.values.orders[place])[part] * self.motor_inertia_inverse
                }),
            };
        }
    }
}
