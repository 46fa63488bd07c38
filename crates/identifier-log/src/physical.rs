//! Physical units: inertia, friction and load of a servo with their standard errors, and the feed-forward of a
//! voltage-driven motor.
//!
//! Motion and command show ratios only, because q̈ = −a q̇ + b u + d − c sign(q̇) holds for any inertia J. A [`Scale`]
//! states the one number that they leave open. From it follow J, viscous friction a J, Coulomb friction c J, load d J
//! and torque per command unit b J. [`VoltageGains`] are ratios and need none.

use serde::Serialize;

use crate::motion_unit::AxisKind;

/// A quantity with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PhysicalQuantity {
    /// Its value.
    pub value: f64,
    /// None for a stated quantity, and if the error is unknown. Infinite, null in JSON, if the motion contains no
    /// information on it.
    pub std_error: Option<f64>,
    /// Its unit.
    pub unit: &'static str,
}

/// An estimate and its standard error, where that is known.
pub type Known = (f64, Option<f64>);

/// The scale of torques.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// The torque of a unit of command at the joint, N·m (N on a linear axis). For a command in A it is the motor's
    /// torque constant times the gear ratio and its efficiency.
    TorqueConstant(f64),
    /// The inertia of all that moves, about the joint, kg·m² (kg on a linear axis).
    Inertia(f64),
    /// The servo was identified with a known payload and without it.
    Payload {
        /// Inertia of the payload about the joint, kg·m² (kg).
        inertia: f64,
        /// b without the payload, rad/s² per command unit, and its standard error.
        bare: Known,
    },
    /// None is known: the joint has an inertia of 1, and torques are those of it.
    Ratios,
}

/// A scale that is not allowed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// A number out of its range.
    #[error("{parameter} = {value} is not allowed: it must be {allowed}")]
    OutOfRange {
        /// The option.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// The values that are allowed.
        allowed: &'static str,
    },
    /// The payload made no difference.
    #[error(
        "payload = {payload} is not allowed: b is {with:.4e} with the payload and {bare:.4e} without, but a payload \
         must reduce b; swap the results, or attach a larger payload"
    )]
    NoPayload {
        /// Inertia of the payload.
        payload: f64,
        /// b with it.
        with: f64,
        /// b without it.
        bare: f64,
    },
}

/// The ratios of a servo that motion and command show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratios {
    /// a, 1/s.
    pub a: Known,
    /// b, rad/s² per command unit.
    pub b: Known,
    /// c, rad/s²; none where it was not estimated.
    pub coulomb: Option<Known>,
    /// d, rad/s²; none where it was not estimated.
    pub load: Option<Known>,
    /// Covariances of a, c and d with b.
    pub with_b: [f64; 3],
    /// Without a stated unit of position there are no units of torque.
    pub axis: AxisKind,
}

/// A servo in physical units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Physical {
    /// Inertia of all that moves, about the joint: J.
    pub inertia: PhysicalQuantity,
    /// Torque of a unit of command: b J.
    pub torque_constant: PhysicalQuantity,
    /// Viscous friction: a J.
    pub viscous: PhysicalQuantity,
    /// Coulomb friction: c J; none where it was not estimated.
    pub coulomb: Option<PhysicalQuantity>,
    /// Torque of the constant load: d J; none where it was not estimated.
    pub load: Option<PhysicalQuantity>,
}

/// Feed-forward of a voltage-driven motor, u = kS sign(v) + kV v + kA v̇ + kG, in the form of WPILib.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VoltageGains {
    /// c/b; none where the friction was not estimated.
    #[serde(rename = "kS")]
    pub ks: Option<PhysicalQuantity>,
    /// a/b.
    #[serde(rename = "kV")]
    pub kv: PhysicalQuantity,
    /// 1/b.
    #[serde(rename = "kA")]
    pub ka: PhysicalQuantity,
    /// −d/b, the voltage that holds the constant load; none where the load was not estimated.
    #[serde(rename = "kG")]
    pub kg: Option<PhysicalQuantity>,
}

/// Units of inertia, torque and viscous friction, and of kV and kA.
const ROTARY: [&str; 5] = ["kg·m²", "N·m", "N·m·s/rad", "V·s/rad", "V·s²/rad"];
const LINEAR: [&str; 5] = ["kg", "N", "N·s/m", "V·s/m", "V·s²/m"];

impl Scale {
    /// The inertia and the torque of a unit of command for a gain b, and the slope of the inertia over b. The error of a
    /// stated one is zero.
    fn of_gain(self, (b, b_error): Known) -> Result<(Known, Known, f64), ScaleError> {
        Ok(match self {
            Self::TorqueConstant(constant) => {
                let constant = above_zero("torque-constant", constant)?;
                let inertia = constant / b;
                let error = b_error.map(|error| inertia * error / b);
                ((inertia, error), (constant, Some(0.0)), -inertia / b)
            }
            Self::Inertia(inertia) => {
                let inertia = above_zero("inertia", inertia)?;
                let error = b_error.map(|error| inertia * error);
                ((inertia, Some(0.0)), (inertia * b, error), 0.0)
            }
            Self::Payload {
                inertia: payload,
                bare,
            } => {
                let payload = above_zero("payload", payload)?;
                let bare_gain = above_zero("bare-gain", bare.0)?;
                let less = bare_gain - b;
                if less <= 0.0 {
                    return Err(ScaleError::NoPayload {
                        payload,
                        with: b,
                        bare: bare_gain,
                    });
                }
                // J = m b₀/(b₀ − b) of all that moves, the payload m included, and K = b J.
                let both = |of_b: f64, of_bare: f64| {
                    let (b_error, bare_error) = (b_error?, bare.1?);
                    Some(payload * (of_b * b_error).hypot(of_bare * bare_error) / (less * less))
                };
                let inertia = payload * bare_gain / less;
                (
                    (inertia, both(bare_gain, b)),
                    (b * inertia, both(bare_gain * bare_gain, b * b)),
                    inertia / less,
                )
            }
            Self::Ratios => ((1.0, Some(0.0)), (b, b_error), 0.0),
        })
    }
}

impl Ratios {
    fn units(&self) -> [&'static str; 5] {
        match self.axis {
            AxisKind::Rotary => ROTARY,
            AxisKind::Linear => LINEAR,
        }
    }

    /// The servo in physical units.
    ///
    /// # Errors
    /// A scale that is not allowed, a gain that is not above zero among them.
    pub fn scaled(&self, scale: Scale) -> Result<Physical, ScaleError> {
        let b = (above_zero("b", self.b.0)?, self.b.1);
        let (inertia, torque_constant, slope) = scale.of_gain(b)?;
        let [of_inertia, of_torque, of_friction, ..] = self.units();
        let [of_a, of_coulomb, of_load] = self.with_b;
        let torque = |of: Known, with_b: f64, unit| product(of, inertia, slope * with_b, unit);
        Ok(Physical {
            inertia: quantity(inertia, of_inertia),
            torque_constant: quantity(torque_constant, of_torque),
            viscous: torque(self.a, of_a, of_friction),
            coulomb: (self.coulomb).map(|coulomb| torque(coulomb, of_coulomb, of_torque)),
            load: self.load.map(|load| torque(load, of_load, of_torque)),
        })
    }

    /// The feed-forward of a servo whose command is in V.
    ///
    /// # Errors
    /// A gain that is not above zero.
    pub fn voltage_gains(&self) -> Result<VoltageGains, ScaleError> {
        let b = above_zero("b", self.b.0)?;
        let [_, _, _, of_kv, of_ka] = self.units();
        let per_b = (1.0 / b, self.b.1.map(|error| error / (b * b)));
        let ratio = |of: Known, with_b: f64, unit| product(of, per_b, -with_b / (b * b), unit);
        let [of_a, of_coulomb, of_load] = self.with_b;
        let load = self.load.map(|(value, error)| (-value, error));
        Ok(VoltageGains {
            ks: (self.coulomb).map(|coulomb| ratio(coulomb, of_coulomb, "V")),
            kv: ratio(self.a, of_a, of_kv),
            ka: ratio((1.0, Some(0.0)), 0.0, of_ka),
            kg: load.map(|load| ratio(load, -of_load, "V")),
        })
    }
}

/// The product of two quantities with their covariance.
fn product(one: Known, other: Known, covariance: f64, unit: &'static str) -> PhysicalQuantity {
    let value = one.0 * other.0;
    let errors = one.1.zip(other.1);
    let std_error = errors.map(|errors| {
        let [of_one, of_other] = [of_zero(other.0, errors.0), of_zero(one.0, errors.1)];
        let both = 2.0 * value * covariance;
        let variance = of_one * of_one + of_other * of_other;
        // Errors without bound have no covariance.
        match both.is_finite() && variance.is_finite() {
            true => (variance + both).max(0.0).sqrt(),
            false => f64::INFINITY,
        }
    });
    PhysicalQuantity {
        value,
        std_error,
        unit,
    }
}

/// A value times an error; nothing of nothing, even where the error is infinite.
fn of_zero(value: f64, error: f64) -> f64 {
    if value.abs() > 0.0 {
        value * error
    } else {
        0.0
    }
}

/// A stated quantity has no standard error.
fn quantity((value, std_error): Known, unit: &'static str) -> PhysicalQuantity {
    PhysicalQuantity {
        value,
        std_error: std_error.filter(|&error| error > 0.0),
        unit,
    }
}

/// A parameter's value, where it can be a size.
///
/// # Errors
/// A number that is not above zero, or not finite.
pub fn above_zero(parameter: &'static str, value: f64) -> Result<f64, ScaleError> {
    let refused = ScaleError::OutOfRange {
        parameter,
        value,
        allowed: "a number above 0",
    };
    (value > 0.0 && value.is_finite())
        .then_some(value)
        .ok_or(refused)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SERVO: Ratios = Ratios {
        a: (0.5, Some(0.05)),
        b: (200.0, Some(2.0)),
        coulomb: Some((8.0, Some(0.4))),
        load: Some((-4.0, Some(0.2))),
        with_b: [0.0; 3],
        axis: AxisKind::Rotary,
    };

    #[track_caller]
    fn assert_close(found: impl Into<Option<PhysicalQuantity>>, value: f64, error: f64) {
        let quantity: PhysicalQuantity = found.into().expect("estimated");
        let off = quantity.value - value;
        assert!(off.abs() < 1e-12 * value.abs(), "{quantity:?}");
        let off = quantity.std_error.expect("known") - error;
        assert!(off.abs() < 1e-12, "{quantity:?}");
    }

    #[test]
    fn a_torque_constant_gives_the_inertia_and_every_torque() {
        let servo = SERVO.scaled(Scale::TorqueConstant(0.4)).expect("allowed");
        // J = K/b; a, c and d are per inertia; the error of b is in all of them.
        let error = |own: f64, value: f64| (own * 0.002).hypot(value * 0.000_02);
        assert_close(servo.inertia, 0.002, 0.000_02);
        assert_close(servo.viscous, 0.001, error(0.05, 0.5));
        assert_close(servo.coulomb, 0.016, error(0.4, 8.0));
        assert_close(servo.load, -0.008, error(0.2, 4.0));
        let units = [Some(servo.inertia), Some(servo.viscous), servo.coulomb];
        let units = units.map(|quantity| quantity.map(|quantity| quantity.unit));
        assert_eq!(units, ["kg·m²", "N·m·s/rad", "N·m"].map(Some));
    }

    /// a and b that err alike leave their ratio as it is: the errors of a large a and of b cancel.
    #[test]
    fn what_errs_with_b_errs_less_over_b() {
        let (a, error) = (10.0, 0.05 * 2.0);
        let together = Ratios {
            a: (a, Some(error)),
            with_b: [error * 2.0, 0.0, 0.0],
            ..SERVO
        };
        let kv = |of: Ratios| of.voltage_gains().expect("a servo").kv;
        assert_close(kv(together), 0.05, 0.0);
        let apart = (error / 200.0).hypot(a * 2.0 / 4e4);
        let alone = Ratios {
            with_b: [0.0; 3],
            ..together
        };
        assert_close(kv(alone), 0.05, apart);
        let viscous = together
            .scaled(Scale::TorqueConstant(0.4))
            .expect("allowed")
            .viscous;
        assert_close(viscous, 0.02, 0.0);
        // With a known inertia the torque is that of a alone.
        let viscous = together
            .scaled(Scale::Inertia(0.002))
            .expect("allowed")
            .viscous;
        assert_close(viscous, 0.02, error * 0.002);
    }

    #[test]
    fn an_inertia_gives_the_torque_constant() {
        let servo = SERVO.scaled(Scale::Inertia(0.002)).expect("allowed");
        assert_close(servo.torque_constant, 0.4, 0.004);
        assert_close(servo.coulomb, 0.016, 0.4 * 0.002);
        assert_eq!(servo.inertia.std_error, None);
    }

    #[test]
    fn a_payload_that_takes_a_fifth_of_the_gain_is_a_fifth_of_the_inertia() {
        let inertia = 0.001;
        let with = |bare| SERVO.scaled(Scale::Payload { inertia, bare });
        let servo = with((250.0, Some(1.0))).expect("it made a difference");
        // J = m b₀/(b₀ − b): derivatives by b and b₀ are m b₀ and m b over (b₀ − b)².
        let error = |of_b: f64, of_bare: f64| 0.001 * (of_b * 2.0).hypot(of_bare) / 2500.0;
        assert_close(servo.inertia, 0.005, error(250.0, 200.0));
        let error = error(250.0 * 250.0, 200.0 * 200.0);
        assert_close(servo.torque_constant, 1.0, error);
        let refused = with((200.0, None)).expect_err("no difference").to_string();
        assert!(refused.contains("larger payload"), "{refused}");
    }

    #[test]
    fn the_voltage_gains_are_ratios() {
        let gains = SERVO.voltage_gains().expect("a servo");
        let error = |own: f64, value: f64| (own / 200.0).hypot(value * 2.0 / 4e4);
        assert_close(gains.ks, 0.04, error(0.4, 8.0));
        assert_close(gains.kv, 0.0025, error(0.05, 0.5));
        assert_close(gains.ka, 0.005, 2.0 / 4e4);
        let kg = gains.kg.expect("estimated");
        assert!(kg.value > 0.0, "it holds a load that pulls down: {kg:?}");
        assert_eq!((gains.ka.unit, kg.unit), ("V·s²/rad", "V"));
    }

    #[test]
    fn an_error_that_is_not_known_is_none_and_one_without_bound_infinite() {
        let unknown = Ratios {
            coulomb: Some((8.0, None)),
            load: None,
            a: (0.0, Some(f64::INFINITY)),
            ..SERVO
        };
        let by_torque = |of: &Ratios| of.scaled(Scale::TorqueConstant(0.4)).expect("allowed");
        let servo = by_torque(&unknown);
        assert_eq!(servo.coulomb.expect("estimated").std_error, None);
        assert_eq!(servo.load, None);
        assert_eq!(servo.viscous.std_error, Some(f64::INFINITY));
        assert_eq!(servo.torque_constant.std_error, None);
        let servo = by_torque(&Ratios {
            b: (200.0, None),
            ..SERVO
        });
        let others = [servo.coulomb, servo.load].map(|quantity| quantity.expect("estimated"));
        for scaled in [servo.inertia, servo.viscous].into_iter().chain(others) {
            assert_eq!(scaled.std_error, None);
        }
    }

    #[test]
    fn what_is_no_scale_is_refused() {
        for number in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for scale in [Scale::TorqueConstant(number), Scale::Inertia(number)] {
                SERVO.scaled(scale).expect_err("no scale");
            }
            let no_servo = Ratios {
                b: (number, None),
                ..SERVO
            };
            no_servo.voltage_gains().expect_err("no gain");
        }
    }
}
