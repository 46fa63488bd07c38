use serde::Serialize;
use serde_json::Value;

use crate::tune::{IdentifiedResult, KnownConditions, ResultError};

/// The scale of torques, which motion and command leave open: q̈ = −a q̇ + b u + d − c sign(q̇) holds for any
/// inertia J, and the torque of a unit of command is b J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// The torque of a unit of command at the joint, N·m (N on a linear axis): the motor's torque constant for a command
    /// in A, times the gear ratio and its efficiency.
    TorqueConstant(f64),
    /// The inertia of all that moves, about the joint, kg·m² (kg on a linear axis).
    Inertia(f64),
    /// None is known: the joint has an inertia of 1, and torques are those of it.
    Ratios,
}

/// A result to export.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    servo: IdentifiedResult,
    /// Standard errors of a, b, Coulomb friction, load and delay, where they are known.
    errors: [Option<f64>; 5],
    /// Largest command, command units, if it is known and finite.
    limit: Option<f64>,
    is_linear: bool,
    origin: Origin,
}

/// Where the figures of a joint come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Origin {
    /// The version of this program that exports.
    pub(super) version: &'static str,
    /// The law that identified.
    pub(super) law: String,
    /// The verdict on the result.
    pub(super) status: String,
    /// The logs, each with its SHA-256.
    pub(super) logs: Vec<[String; 2]>,
}

/// A quantity with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Quantity {
    pub(super) value: f64,
    /// None for a quantity that was stated, and where a result has no standard error.
    pub(super) std_error: Option<f64>,
    pub(super) unit: &'static str,
}

/// A joint in physical units. The errors take the estimates for independent, for a result does not hold their
/// correlations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Joint {
    pub(super) name: String,
    /// Inertia of all that moves, about the joint: J.
    pub(super) inertia: Quantity,
    /// The part of it that the robot's model does not have: J without the links'.
    pub(super) armature: Quantity,
    /// Torque of a unit of command: b J.
    pub(super) torque_constant: Quantity,
    /// Viscous friction: a J.
    pub(super) damping: Quantity,
    /// Coulomb friction: c J.
    pub(super) friction: Quantity,
    /// Torque of the constant load: d J.
    pub(super) load: Quantity,
    /// From the encoder's reading to the torque.
    pub(super) delay: Quantity,
    /// Largest command, if it is known, and the torque that it makes.
    pub(super) command_limit: Option<f64>,
    pub(super) effort_limit: Option<f64>,
    /// True if an inertia of 1 stands for one that is not known.
    pub(super) has_unit_inertia: bool,
    pub(super) is_linear: bool,
    pub(super) origin: Origin,
}

/// A fault of what is to be exported.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// A name that not every format can hold.
    #[error(
        "joint = {0:?} is not allowed: a name has letters, digits, and the signs - _ . / only; --joint states it"
    )]
    Name(String),
    /// A scale or an inertia of links is out of its range.
    #[error("{parameter} = {value} is not allowed: it must be {allowed}")]
    OutOfRange {
        /// The option.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// The values that are allowed.
        allowed: &'static str,
    },
    /// The links have more inertia than all that moves.
    #[error(
        "link-inertia = {links} is not allowed: all that moves has {inertia:.4e}, the model's links included; state the links' inertia about this joint, or a larger torque constant"
    )]
    Links {
        /// Inertia of the links.
        links: f64,
        /// Inertia of all that moves.
        inertia: f64,
    },
}

impl Identified {
    /// Reads a result; another limit of the command may be stated.
    ///
    /// # Errors
    /// The key that is missing or holds what is not allowed.
    pub fn read(json: &str, limit: Option<f64>) -> Result<Self, ResultError> {
        let servo = IdentifiedResult::read(json)?;
        // The largest command of a log is no limit of the drive.
        let known = KnownConditions::of_result(json, servo.has_delay);
        let known = known.limit.filter(|_| !known.is_command_of_log);
        let known = known.map(|[low, high]| high.min(-low));
        let value: Value = serde_json::from_str(json).unwrap_or_default();
        let text = |pointer: &str| {
            let found = value.pointer(pointer).and_then(Value::as_str);
            found.unwrap_or_default().to_owned()
        };
        let logs = value.pointer("/origin/logs").and_then(Value::as_array);
        let log = |log: &Value| {
            ["file", "sha256"].map(|key| log[key].as_str().unwrap_or_default().to_owned())
        };
        let errors = ["a", "b", "coulomb", "load", "delay"];
        let error = |name| {
            value
                .pointer(&format!("/estimates/{name}/std_error"))?
                .as_f64()
        };
        Ok(Self {
            errors: errors.map(error),
            limit: limit.or(known).filter(|limit| limit.is_finite()),
            is_linear: text("/estimates/b/unit").starts_with("m/"),
            origin: Origin {
                version: crate::program::VERSION,
                law: text("/law"),
                status: text("/status"),
                logs: logs.into_iter().flatten().map(log).collect(),
            },
            servo,
        })
    }

    /// The reason why nothing should be built on it, if there is one.
    #[must_use]
    pub fn doubt(&self) -> Option<&str> {
        self.servo.doubt.as_deref()
    }

    /// The joint of this name in physical units, about which the robot's model has links of an inertia already.
    ///
    /// # Errors
    /// A scale or an inertia that is not allowed.
    pub fn joint(&self, name: &str, scale: Scale, links: f64) -> Result<Joint, ExportError> {
        let above_zero = |parameter, value: f64| {
            let refused = ExportError::OutOfRange {
                parameter,
                value,
                allowed: "a number above 0",
            };
            (value > 0.0 && value.is_finite())
                .then_some(value)
                .ok_or(refused)
        };
        let is_allowed = |sign: char| sign.is_alphanumeric() || "-_./".contains(sign);
        if name.is_empty() || !name.chars().all(is_allowed) {
            return Err(ExportError::Name(name.to_owned()));
        }
        if !(links >= 0.0 && links.is_finite()) {
            return Err(ExportError::OutOfRange {
                parameter: "link-inertia",
                value: links,
                allowed: "a number of at least 0",
            });
        }
        let servo = &self.servo.servo;
        let parameters = servo.parameters;
        let [a, b, c, d, delay] = self.errors;
        let a = (parameters.a, a);
        let b = (parameters.b, b);
        let c = (parameters.coulomb, c);
        let d = (parameters.load, d);
        let (inertia, torque_constant) = match scale {
            Scale::TorqueConstant(constant) => {
                let constant = above_zero("torque-constant", constant)?;
                let inertia = constant / b.0;
                let error = b.1.map(|error| inertia * error / b.0);
                ((inertia, error), (constant, None))
            }
            Scale::Inertia(inertia) => {
                let inertia = above_zero("inertia", inertia)?;
                let error = b.1.map(|error| inertia * error);
                ((inertia, None), (inertia * b.0, error))
            }
            Scale::Ratios => ((1.0, None), b),
        };
        let armature = inertia.0 - links;
        if armature <= 0.0 {
            return Err(ExportError::Links {
                links,
                inertia: inertia.0,
            });
        }
        let of_inertia = |(value, error): (f64, Option<f64>), unit| Quantity {
            value: value * inertia.0,
            std_error: error
                .map(|error| (error * inertia.0).hypot(value * inertia.1.unwrap_or_default())),
            unit,
        };
        let units = if self.is_linear {
            ["kg", "N", "N·s/m"]
        } else {
            ["kg·m²", "N·m", "N·m·s/rad"]
        };
        let quantity = |(value, std_error), unit| Quantity {
            value,
            std_error,
            unit,
        };
        Ok(Joint {
            name: name.to_owned(),
            inertia: quantity(inertia, units[0]),
            armature: quantity((armature, inertia.1), units[0]),
            torque_constant: quantity(torque_constant, units[1]),
            damping: of_inertia(a, units[2]),
            friction: of_inertia(c, units[1]),
            load: of_inertia(d, units[1]),
            delay: quantity((servo.delay, delay), "s"),
            command_limit: self.limit,
            effort_limit: self.limit.map(|limit| limit * torque_constant.0),
            has_unit_inertia: scale == Scale::Ratios,
            is_linear: self.is_linear,
            origin: self.origin.clone(),
        })
    }
}

impl Joint {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Sentences on the joint for a reader, a line each, without a pair of hyphens, which no comment of XML may have.
    pub(super) fn remarks(&self) -> Vec<String> {
        let shown = |name: &str, quantity: Quantity| {
            let Quantity {
                value,
                std_error,
                unit,
            } = quantity;
            let error = std_error.map_or(String::new(), |error| format!(" ± {error:.1e}"));
            format!("{name} {value:.4e}{error} {unit}")
        };
        let Origin {
            version,
            law,
            status,
            logs,
        } = &self.origin;
        let mut lines = vec![format!(
            "{}: identified by {} {version}, law {law}, {status}; ± is the standard error.",
            self.name,
            crate::program::NAME
        )];
        lines.extend(
            logs.iter()
                .map(|[file, hash]| format!("log {file}, SHA-256 {hash}")),
        );
        if self.has_unit_inertia {
            lines.push(
                "The inertia is not known: 1 stands for it, and every torque is for that inertia."
                    .to_owned(),
            );
        }
        let inertia = shown("inertia of all that moves", self.inertia);
        if self.armature == self.inertia {
            lines.push(format!(
                "{inertia}; the links of the model are taken to have none"
            ));
        } else {
            lines.push(inertia);
            lines.push(shown("without the links of the model", self.armature));
        }
        lines.push(shown("torque of a unit of command", self.torque_constant));
        lines.push(shown("viscous friction", self.damping));
        lines.push(shown("Coulomb friction", self.friction));
        lines.push(shown(
            "load, which this format has no place for:",
            self.load,
        ));
        lines.push(shown(
            "delay from the encoder's reading to the torque",
            self.delay,
        ));
        for line in &mut lines {
            *line = line
                .replace("--", "-\u{2010}")
                .replace(char::is_control, " ");
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RESULT: &str = r#"{
        "law": "fit", "status": "converged", "reason": "", "sample_time": 0.001,
        "estimates": {
            "a": { "value": 0.5, "std_error": 0.05 },
            "b": { "value": 200.0, "std_error": 2.0, "unit": "rad/s² per command unit" },
            "coulomb": { "value": 8.0, "std_error": 0.4 },
            "load": { "value": -4.0, "std_error": 0.2 },
            "delay": { "value": 0.001, "std_error": 0.0001 }
        }
    }"#;

    fn joint(scale: Scale, links: f64) -> Result<Joint, ExportError> {
        let identified = Identified::read(RESULT, Some(5.0)).expect("a result");
        identified.joint("elbow", scale, links)
    }

    fn assert_close(quantity: Quantity, value: f64, error: f64) {
        let Quantity {
            value: found,
            std_error,
            ..
        } = quantity;
        assert!((found - value).abs() < 1e-12 * value.abs(), "{quantity:?}");
        let is_close = std_error.is_some_and(|found| (found - error).abs() < 1e-12);
        assert!(is_close, "{quantity:?}");
    }

    #[test]
    fn a_torque_constant_gives_the_inertia_and_every_torque() {
        let joint = joint(Scale::TorqueConstant(0.4), 0.0).expect("allowed");
        // J = k/b; a, c and d are per inertia; the error of b is in all of them.
        assert_close(joint.inertia, 0.002, 0.000_02);
        assert_close(
            joint.damping,
            0.001,
            (0.05_f64 * 0.002).hypot(0.5 * 0.000_02),
        );
        assert_close(
            joint.friction,
            0.016,
            (0.4_f64 * 0.002).hypot(8.0 * 0.000_02),
        );
        assert_close(joint.load, -0.008, (0.2_f64 * 0.002).hypot(4.0 * 0.000_02));
        assert_eq!(joint.effort_limit, Some(2.0));
    }

    #[test]
    fn an_error_that_is_not_known_is_none_and_not_zero() {
        let without = RESULT.replace(", \"std_error\": 0.4", "");
        let identified = Identified::read(&without, None).expect("a result");
        let joint = identified.joint("elbow", Scale::TorqueConstant(0.4), 0.0);
        let joint = joint.expect("allowed");
        assert_eq!(joint.friction.std_error, None);
        assert_eq!(joint.torque_constant.std_error, None);
        assert!(joint.damping.std_error.is_some());
    }

    #[test]
    fn an_inertia_gives_the_torque_constant() {
        let joint = joint(Scale::Inertia(0.002), 0.0).expect("allowed");
        assert_close(joint.torque_constant, 0.4, 0.004);
        assert_close(joint.friction, 0.016, 0.4 * 0.002);
    }

    #[test]
    fn without_either_the_inertia_is_one() {
        let joint = joint(Scale::Ratios, 0.0).expect("allowed");
        assert_close(joint.torque_constant, 200.0, 2.0);
        assert_close(joint.damping, 0.5, 0.05);
        assert!(
            joint
                .remarks()
                .iter()
                .any(|line| line.contains("is not known"))
        );
    }

    #[test]
    fn the_inertia_of_the_links_is_not_counted_twice() {
        let whole = joint(Scale::TorqueConstant(0.4), 0.0005).expect("allowed");
        assert_close(whole.armature, 0.0015, 0.000_02);
        let error = joint(Scale::TorqueConstant(0.4), 0.003).expect_err("more than all");
        assert!(error.to_string().contains("2.0000e-3"), "{error}");
        for links in [-1.0, f64::NAN] {
            joint(Scale::TorqueConstant(0.4), links).expect_err("no inertia");
        }
        for constant in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            joint(Scale::TorqueConstant(constant), 0.0).expect_err("no constant");
            joint(Scale::Inertia(constant), 0.0).expect_err("no inertia");
        }
    }
}
