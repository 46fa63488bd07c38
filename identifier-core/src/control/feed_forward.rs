use crate::error::{Allowed, OutOfRange};
use crate::number::Number;
use crate::units::Units;

/// What a feed-forward knows, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FeedForwardSettings {
    /// a, 1/s.
    pub a: f64,
    /// b, rad/s² per command unit.
    pub b: f64,
    /// Coulomb friction c, rad/s².
    pub coulomb: f64,
    /// Load d, rad/s²; zero where the controller's integral holds it: only one of them may.
    pub load: f64,
    /// [g_s, g_c], rad/s²: gravity accelerates the servo by g_s sin q + g_c cos q.
    pub gravity: [f64; 2],
    /// Derivative gain of the controller beside it, command units per rad/s: what it takes away on the
    /// measured velocity is given back on that of the reference.
    pub kd: f64,
    /// The speed of the reference from which on friction is met in full, rad/s; below it in proportion, so
    /// that a reference that stands asks for nothing.
    pub sign_speed: f64,
}

/// Feed-forward on the motion of the reference, machine units:
///
/// u = (q̈_r + a q̇_r + c s(q̇_r) − d − g_s sin q_r − g_c cos q_r)/b + k_d q̇_r,
///
/// where s(v) is v/[`sign_speed`](FeedForwardSettings::sign_speed), limited to ±1. It is added to the
/// controller's command in front of the limit.
///
/// A command acts from τ after its sample on and is held for T: the motion to be given is that of
/// the reference τ + T/2 later.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedForward<N> {
    acceleration: N,
    velocity: N,
    friction: N,
    sign: N,
    constant: N,
    gravity: Option<[N; 2]>,
}

/// The motion of a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ReferenceMotion<N> {
    /// Position as an angle, rad; only gravity asks for it.
    pub angle: N,
    /// Velocity, machine units.
    pub velocity: N,
    /// Acceleration, machine units.
    pub acceleration: N,
}

impl<N: Number> FeedForward<N> {
    /// The feed-forward for a servo.
    ///
    /// # Errors
    /// The setting that is out of its range: b and `sign_speed` must be positive, a, Coulomb friction and
    /// `kd` not negative, load and gravity finite.
    pub fn new(units: &Units, settings: &FeedForwardSettings) -> Result<Self, OutOfRange> {
        let not_negative = Allowed::AtLeast(0.0);
        let b = Allowed::Above(0.0).check("b", settings.b)?;
        let a = not_negative.check("a", settings.a)?;
        let coulomb = not_negative.check("coulomb", settings.coulomb)?;
        let load = Allowed::Finite.check("load", settings.load)?;
        let kd = not_negative.check("kd", settings.kd)?;
        let sign_speed = Allowed::Above(0.0).check("sign_speed", settings.sign_speed)?;
        let [sine, cosine] = settings.gravity;
        let gravity = [
            Allowed::Finite.check("gravity_sine", sine)?,
            Allowed::Finite.check("gravity_cosine", cosine)?,
        ];
        let weighs = sine != 0.0 || cosine != 0.0;
        Ok(Self {
            acceleration: N::from_f64(1.0 / (b * units.acceleration())),
            velocity: N::from_f64((a / b + kd) / units.velocity()),
            friction: N::from_f64(coulomb / b),
            sign: N::from_f64(1.0 / (sign_speed * units.velocity())),
            constant: N::from_f64(-load / b),
            gravity: weighs.then(|| gravity.map(|part| N::from_f64(-part / b))),
        })
    }

    /// The command for a motion of the reference.
    #[inline]
    pub fn command(&self, motion: &ReferenceMotion<N>) -> N {
        let sign = (self.sign * motion.velocity).limited(-N::ONE, N::ONE);
        let command = self.acceleration * motion.acceleration
            + self.velocity * motion.velocity
            + self.friction * sign
            + self.constant;
        match self.gravity {
            None => command,
            Some([of_sine, of_cosine]) => {
                let (sine, cosine) = motion.angle.sine_cosine();
                command + of_sine * sine + of_cosine * cosine
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: FeedForwardSettings = FeedForwardSettings {
        a: 2.0,
        b: 50.0,
        coulomb: 5.0,
        load: -10.0,
        gravity: [7.0, -3.0],
        kd: 0.25,
        sign_speed: 0.1,
    };

    fn command(angle: f64, velocity: f64, acceleration: f64) -> f64 {
        let units = Units::new(1e-3, 1e-4).expect("valid");
        let feed_forward = FeedForward::<f64>::new(&units, &SETTINGS).expect("valid");
        feed_forward.command(&ReferenceMotion {
            angle,
            velocity: velocity * units.velocity(),
            acceleration: acceleration * units.acceleration(),
        })
    }

    #[test]
    fn it_is_the_servo_solved_for_the_command() {
        let (angle, velocity, acceleration) = (0.7_f64, -3.0, 20.0);
        let weight = 7.0 * angle.sin() - 3.0 * angle.cos();
        let expected =
            (acceleration + 2.0 * velocity - 5.0 + 10.0 - weight) / 50.0 + 0.25 * velocity;
        assert!((command(angle, velocity, acceleration) - expected).abs() < 1e-12);
    }

    #[test]
    fn friction_is_met_in_proportion_at_low_speed_and_not_at_all_at_standstill() {
        let friction = |velocity: f64| {
            command(0.0, velocity, 0.0) - command(0.0, 0.0, 0.0) - (2.0 / 50.0 + 0.25) * velocity
        };
        assert!(friction(0.0).abs() < 1e-12);
        for (velocity, expected) in [
            (0.05, 0.05),
            (0.1, 0.1),
            (4.0, 0.1),
            (-0.02, -0.02),
            (-1.0, -0.1),
        ] {
            assert!((friction(velocity) - expected).abs() < 1e-12, "{velocity}");
        }
    }

    #[test]
    fn what_is_no_servo_is_refused_by_name() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        for (bad, name) in [
            (FeedForwardSettings { b: 0.0, ..SETTINGS }, "b"),
            (
                FeedForwardSettings {
                    a: -1.0,
                    ..SETTINGS
                },
                "a",
            ),
            (
                FeedForwardSettings {
                    load: f64::NAN,
                    ..SETTINGS
                },
                "load",
            ),
            (
                FeedForwardSettings {
                    sign_speed: 0.0,
                    ..SETTINGS
                },
                "sign_speed",
            ),
            (
                FeedForwardSettings {
                    gravity: [0.0, f64::INFINITY],
                    ..SETTINGS
                },
                "gravity_cosine",
            ),
        ] {
            let refused = FeedForward::<f32>::new(&units, &bad).expect_err("out of range");
            assert_eq!(refused.parameter, name);
        }
    }
}
