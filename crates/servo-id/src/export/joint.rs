use identifier_log::AxisKind;
use identifier_log::physical::{Known, PhysicalQuantity, Ratios, Scale, ScaleError, above_zero};
use identifier_log::provenance::Task;
use identifier_log::result::KeptResult;
use identifier_log::scenario::Options;
use identifier_log::tune::{IdentifiedResult, KnownConditions, ResultError};
use serde::Serialize;

/// A result to export.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    servo: IdentifiedResult,
    ratios: Ratios,
    /// Standard error of the delay, where it is known.
    delay_error: Option<f64>,
    /// The scale of torques that the result's scenario states.
    scale: Option<Scale>,
    /// Largest command, command units, if it is known and finite.
    limit: Option<f64>,
    origin: Origin,
}

/// Where the figures of a joint come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Origin {
    /// The version of this program that exports.
    pub(super) version: &'static str,
    /// The estimator that identified.
    pub(super) law: String,
    /// The verdict on the result.
    pub(super) status: String,
    /// The logs, each with its SHA-256.
    pub(super) logs: Vec<[String; 2]>,
    /// How their columns were read.
    pub(super) reading: Vec<String>,
}

/// A joint in physical units. The errors take the estimates for independent, for a result does not hold their
/// correlations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Joint {
    pub(super) name: String,
    /// Inertia of all that moves, about the joint: J.
    pub(super) inertia: PhysicalQuantity,
    /// The part of it that the robot's model does not have: J without the links'.
    pub(super) armature: PhysicalQuantity,
    /// Torque of a unit of command: b J.
    pub(super) torque_constant: PhysicalQuantity,
    /// Viscous friction: a J.
    pub(super) damping: PhysicalQuantity,
    /// Coulomb friction: c J.
    pub(super) friction: PhysicalQuantity,
    /// Torque of the constant load: d J.
    pub(super) load: PhysicalQuantity,
    /// From the encoder's reading to the torque.
    pub(super) delay: PhysicalQuantity,
    /// Largest command, if it is known, and the torque that it makes.
    pub(super) command_limit: Option<f64>,
    pub(super) effort_limit: Option<f64>,
    /// True if an inertia of 1 replaces an unknown one.
    pub(super) has_unit_inertia: bool,
    pub(super) is_linear: bool,
    /// The motor behind a command in V, where its resistance is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) motor: Option<Motor>,
    pub(super) origin: Origin,
}

/// A motor driven by a voltage, referred to the joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Motor {
    /// Winding resistance R, Ω.
    pub(super) resistance: f64,
    /// Torque of an ampere, and voltage of 1 rad/s: k = K R of the torque K of a volt.
    pub(super) torque_constant: PhysicalQuantity,
    /// Viscous friction without the part k²/R that the motor's own voltage brakes.
    pub(super) damping: PhysicalQuantity,
}

/// A fault of what is to be exported.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// A name that not every format can hold.
    #[error(
        "joint = {0:?} is not allowed: a name has only letters, digits and - _ . / ; state it with --joint"
    )]
    Name(String),
    /// A scale is not allowed.
    #[error(transparent)]
    Scale(#[from] ScaleError),
    /// The inertia of the links is out of its range.
    #[error("link-inertia = {0} is not allowed: it must be a number of at least 0")]
    LinkInertia(f64),
    /// The motor brakes more than all that does.
    #[error(
        "resistance = {resistance} is not allowed: it gives the motor a damping of {braking:.4e} N·m·s/rad, more \
         than the total of {damping:.4e}; state the resistance between the motor's terminals, at most {}, or none \
         for a command in A",
        damping * resistance / braking
    )]
    Resistance {
        /// The resistance, Ω.
        resistance: f64,
        /// Its braking.
        braking: f64,
        /// The whole viscous friction.
        damping: f64,
    },
    /// A format of one joint.
    #[error(
        "a BAM file holds one actuator, but there are {0} joints: export each result to its own file"
    )]
    Several(usize),
    /// The links have more inertia than all that moves.
    #[error(
        "link-inertia = {links} is not allowed: the total inertia, with the model's links, is {inertia:.4e}; state \
         the links' inertia about this joint, or a larger torque constant"
    )]
    Links {
        /// Inertia of the links.
        links: f64,
        /// Inertia of all that moves.
        inertia: f64,
    },
}

impl Identified {
    /// Of a result; another limit of the command may be stated.
    ///
    /// # Errors
    /// The key that is missing or holds what is not allowed.
    pub fn new(result: &KeptResult, limit: Option<f64>) -> Result<Self, ResultError> {
        let servo = IdentifiedResult::new(result)?;
        // The largest command of a log is no limit of the drive.
        let known = KnownConditions::of_result(result, servo.has_delay);
        let known = known.limit.filter(|_| !known.is_command_of_log);
        let known = known.map(|[low, high]| high.min(-low));
        let error = |name| result.std_error(name);
        let origin = result.origin.as_ref();
        let logs = match origin.map(|origin| &origin.task) {
            Some(Task::Replay { logs, .. }) => &logs[..],
            _ => &[],
        };
        let logs = logs
            .iter()
            .map(|log| [log.file.display().to_string(), log.sha256.clone()]);
        let scenario = origin.and_then(|origin| Options::of_origin(origin).ok());
        let found = servo.model.servo.parameters;
        // A result of an earlier version has its unit in its scenario only.
        let of_scenario = scenario
            .as_ref()
            .map(|scenario| scenario.motion_unit().axis());
        let axis = of_scenario.and_then(Result::ok).unwrap_or(servo.axis);
        Ok(Self {
            ratios: Ratios {
                a: (found.a, error("a")),
                b: (found.b, error("b")),
                coulomb: Some((found.coulomb, error("coulomb"))),
                load: Some((found.load, error("load"))),
                with_b: ["a", "coulomb", "load"].map(|name| {
                    let of = result.covariance.as_ref().and_then(|of| of.of(name, "b"));
                    of.unwrap_or(0.0)
                }),
                axis,
            },
            delay_error: error("delay"),
            scale: scenario.and_then(|scenario| scenario.physical.scale()),
            limit: limit.or(known).filter(|limit| limit.is_finite()),
            origin: Origin {
                version: crate::program::VERSION,
                law: result.law.clone(),
                status: result.status.clone(),
                logs: logs.collect(),
                reading: servo
                    .reading
                    .as_ref()
                    .map_or_else(Vec::new, |of| of.lines()),
            },
            servo,
        })
    }

    /// The reason why nothing should be built on it, if there is one.
    #[must_use]
    pub fn reservation(&self) -> Option<&str> {
        self.servo.reservation.as_deref()
    }

    /// The scale of torques that the result's own scenario states.
    #[must_use]
    pub fn scale(&self) -> Option<Scale> {
        self.scale
    }

    /// b and its standard error, as that of the servo without a payload.
    #[must_use]
    pub fn gain(&self) -> Known {
        self.ratios.b
    }

    /// The joint of this name in physical units, about which the robot's model has links of an inertia already.
    ///
    /// # Errors
    /// A scale or an inertia that is not allowed.
    pub fn joint(&self, name: &str, scale: Scale, links: f64) -> Result<Joint, ExportError> {
        let is_allowed = |sign: char| sign.is_alphanumeric() || "-_./".contains(sign);
        if name.is_empty() || !name.chars().all(is_allowed) {
            return Err(ExportError::Name(name.to_owned()));
        }
        if !(links >= 0.0 && links.is_finite()) {
            return Err(ExportError::LinkInertia(links));
        }
        let servo = self.ratios.scaled(scale)?;
        let (inertia, torque_constant) = (servo.inertia, servo.torque_constant);
        let armature = inertia.value - links;
        if armature <= 0.0 {
            return Err(ExportError::Links {
                links,
                inertia: inertia.value,
            });
        }
        let none = PhysicalQuantity {
            value: 0.0,
            std_error: None,
            unit: torque_constant.unit,
        };
        Ok(Joint {
            name: name.to_owned(),
            inertia,
            armature: PhysicalQuantity {
                value: armature,
                ..inertia
            },
            torque_constant,
            damping: servo.viscous,
            friction: servo.coulomb.unwrap_or(none),
            load: servo.load.unwrap_or(none),
            delay: PhysicalQuantity {
                value: self.servo.model.servo.delay,
                std_error: self.delay_error,
                unit: "s",
            },
            command_limit: self.limit,
            effort_limit: self.limit.map(|limit| limit * torque_constant.value),
            has_unit_inertia: scale == Scale::Ratios,
            is_linear: self.ratios.axis == AxisKind::Linear,
            motor: None,
            origin: self.origin.clone(),
        })
    }
}

impl Joint {
    /// The joint of a motor of this winding resistance, Ω, whose command is its voltage.
    ///
    /// # Errors
    /// A resistance that is not above 0, or with which the motor alone would brake more than all that does.
    pub fn with_resistance(mut self, resistance: f64) -> Result<Self, ExportError> {
        /// Standard errors by which a friction may be below zero.
        const SIDES: f64 = 3.0;
        above_zero("resistance", resistance)?;
        let per_volt = self.torque_constant;
        let braking = per_volt.value * per_volt.value * resistance;
        let damping = self.damping.value - braking;
        if damping < -SIDES * self.damping.std_error.unwrap_or(0.0) {
            return Err(ExportError::Resistance {
                resistance,
                braking,
                damping: self.damping.value,
            });
        }
        self.motor = Some(Motor {
            resistance,
            torque_constant: PhysicalQuantity {
                value: per_volt.value * resistance,
                std_error: per_volt.std_error.map(|error| error * resistance),
                ..per_volt
            },
            damping: PhysicalQuantity {
                value: damping.max(0.0),
                ..self.damping
            },
        });
        Ok(self)
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Sentences on the joint for a reader, a line each. They contain no pair of hyphens, which no comment of XML may
    /// have.
    pub(super) fn remarks(&self) -> Vec<String> {
        let shown = |name: &str, quantity: PhysicalQuantity| {
            let error = quantity.std_error.map_or(String::new(), |error| {
                format!(" ± {:.1e}", crate::SIDES * error)
            });
            format!("{name} {:.4e}{error} {}", quantity.value, quantity.unit)
        };
        let own = &self.origin;
        let (version, law, status, logs) = (&own.version, &own.law, &own.status, &own.logs);
        let mut lines = vec![format!(
            "{}: identified by {} {version}, estimator {law}, {status}; ± is the 95 % interval.",
            self.name,
            crate::program::NAME
        )];
        lines.extend(
            logs.iter()
                .map(|[file, hash]| format!("log {file}, SHA-256 {hash}")),
        );
        lines.extend(own.reading.iter().map(|of| format!("read as {of}")));
        if self.has_unit_inertia {
            lines.push(
                "The inertia is unknown and set to 1; every torque is for that inertia.".to_owned(),
            );
        }
        let inertia = shown("total inertia", self.inertia);
        if self.armature == self.inertia {
            lines.push(format!(
                "{inertia}; the model's links are assumed to have none"
            ));
        } else {
            lines.push(inertia);
            lines.push(shown("without the links of the model", self.armature));
        }
        lines.push(shown("torque per command unit", self.torque_constant));
        lines.push(shown("viscous friction", self.damping));
        lines.push(shown("Coulomb friction", self.friction));
        lines.push(shown("load, which this format cannot hold:", self.load));
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
        let kept = KeptResult::read(RESULT).expect("a result");
        let identified = Identified::new(&kept, Some(5.0)).expect("a result");
        identified.joint("elbow", scale, links)
    }

    fn assert_close(found: PhysicalQuantity, value: f64, error: f64) {
        let is_close = |one: f64, other: f64| (one - other).abs() < 1e-12;
        assert!(is_close(found.value, value), "{found:?}");
        let std_error = found.std_error;
        assert!(
            std_error.is_some_and(|std_error| is_close(std_error, error)),
            "{found:?}"
        );
    }

    #[test]
    fn without_either_the_inertia_is_one() {
        let joint = joint(Scale::Ratios, 0.0).expect("allowed");
        assert_close(joint.torque_constant, 200.0, 2.0);
        assert_close(joint.damping, 0.5, 0.05);
        assert!(joint.remarks().iter().any(|line| line.contains("set to 1")));
    }
}
