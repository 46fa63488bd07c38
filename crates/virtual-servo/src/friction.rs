//! Friction that depends on speed and direction.

use identifier_core::parameters::ServoParameters;

use crate::Effects;
use crate::effects::any;

/// Deceleration by friction under a push p of the motor, rad/s²: a q̇ + κ |q̇| q̇ + sign(q̇) (δa |q̇| + c + s
/// e^(−(q̇/v)²) + λ |p|).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Friction {
    /// a, 1/s.
    pub(crate) viscous: f64,
    /// δa, 1/s.
    pub(crate) asymmetry: f64,
    /// c, rad/s².
    pub(crate) coulomb: f64,
    /// s, rad/s².
    pub(crate) low_speed: f64,
    /// 1/v, s/rad.
    pub(crate) per_low_speed_velocity: f64,
    /// κ, 1/rad.
    pub(crate) quadratic: f64,
    /// λ.
    pub(crate) load_dependent: f64,
}

impl Friction {
    /// The friction of a servo with effects.
    pub(crate) fn new(servo: &ServoParameters, effects: &Effects) -> Self {
        Self {
            viscous: servo.a,
            asymmetry: effects.asymmetry,
            coulomb: servo.coulomb,
            low_speed: effects.low_speed_friction,
            per_low_speed_velocity: if effects.low_speed_friction == 0.0 {
                0.0
            } else {
                1.0 / effects.low_speed_velocity
            },
            quadratic: effects.quadratic_friction,
            load_dependent: effects.load_dependent_friction,
        }
    }

    /// That much of it.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self {
            viscous: factor * self.viscous,
            asymmetry: factor * self.asymmetry,
            coulomb: factor * self.coulomb,
            low_speed: factor * self.low_speed,
            quadratic: factor * self.quadratic,
            load_dependent: factor * self.load_dependent,
            ..self
        }
    }

    /// True if it depends on the direction, so that a reversal is an event.
    pub(crate) fn has_directions(&self) -> bool {
        any([
            self.asymmetry,
            self.coulomb,
            self.low_speed,
            self.load_dependent,
        ])
    }

    /// The breakaway friction of a servo at rest under a push of the motor, rad/s².
    pub(crate) fn breakaway(&self, push: f64) -> f64 {
        self.coulomb + self.low_speed + self.load_dependent * push.abs()
    }

    /// The deceleration at a velocity, in a direction of ±1, under a force of the motor.
    #[inline]
    pub(crate) fn deceleration(&self, velocity: f64, direction: f64, push: f64) -> f64 {
        let mut level = self.coulomb + self.load_dependent * push.abs();
        if self.low_speed != 0.0 {
            let relative = velocity * self.per_low_speed_velocity;
            level += self.low_speed * libm::exp(-relative * relative);
        }
        let viscous = self.viscous + direction * self.asymmetry + self.quadratic * velocity.abs();
        viscous * velocity + direction * level
    }
}
