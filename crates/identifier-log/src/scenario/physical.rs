//! The keys of `[physical]`: the scale of torques, and the unit of the command.

use log_fit::{Axis, Logged, Way};

use super::Options;
use super::error::Fault;
use super::log_units::PositionUnit;
use super::names::named;
use crate::column_reading::Reading;
use crate::motion_unit::{AxisKind, MotionUnit};
use crate::physical::Scale;

/// The physical quantities that turn a result's ratios into physical units, where they are stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalSettings {
    /// The unit of the command.
    pub command_unit: CommandUnit,
    /// Torque of a unit of command at the joint, N·m (N on a linear axis).
    pub torque_constant: Option<f64>,
    /// Inertia of all that moves about the joint, kg·m² (kg).
    pub inertia: Option<f64>,
    /// Inertia of the payload that was attached, kg·m² (kg).
    pub payload: Option<f64>,
    /// b without it, rad/s² per command unit, and its standard error.
    pub bare_gain: Option<[f64; 2]>,
}

named! {
    /// The unit of a command.
    pub enum CommandUnit {
        /// None that is known.
        Other = "other",
        /// Volts at the motor.
        Volt = "V",
        /// Amperes.
        Ampere = "A",
        /// Newton metres at the joint.
        NewtonMetre = "Nm",
        /// Newtons, of a linear axis.
        Newton = "N",
    }
}

impl CommandUnit {
    /// The unit of a command as it was read; none where nothing states it.
    #[must_use]
    pub fn of_reading(reading: &Reading) -> Option<Self> {
        let unit = reading.command.as_ref()?.of.unit.as_deref()?;
        let unit = unit.replace([' ', '·', '.'], "").parse().ok();
        unit.filter(|unit| *unit != Self::Other)
    }
}

impl PhysicalSettings {
    /// Nothing is stated.
    pub const NONE: Self = Self {
        command_unit: CommandUnit::Other,
        torque_constant: None,
        inertia: None,
        payload: None,
        bare_gain: None,
    };

    /// The torque of a unit of command, N·m (N on a linear axis), where it is declared.
    pub(super) fn known_torque_constant(&self) -> Option<f64> {
        match self.scale() {
            Some(Scale::TorqueConstant(constant)) => Some(constant),
            _ => None,
        }
    }

    /// The scale of torques; none where nothing fixes it.
    #[must_use]
    pub fn scale(&self) -> Option<Scale> {
        let payload = || {
            let [b, error] = self.bare_gain?;
            Some(Scale::Payload {
                inertia: self.payload?,
                bare: (b, Some(error)),
            })
        };
        match self.command_unit {
            CommandUnit::NewtonMetre | CommandUnit::Newton => Some(Scale::TorqueConstant(1.0)),
            _ => (self.torque_constant.map(Scale::TorqueConstant))
                .or(self.inertia.map(Scale::Inertia))
                .or_else(payload),
        }
    }
}

impl Options {
    /// The unit of its positions; for that of an axis in m, m is read for rad everywhere.
    #[must_use]
    pub fn motion_unit(&self) -> MotionUnit {
        match self.physical.command_unit {
            CommandUnit::Newton => MotionUnit::Stated(AxisKind::Linear),
            _ => self.log_columns().motion_unit(),
        }
    }

    /// What is known of the rows of its logs.
    pub(crate) fn axis(&self) -> Axis {
        let way = match self.motion_unit().axis() {
            Ok(_) => Way::Turn(self.stated.identifier.terms.revolution),
            Err(_) => Way::Path {
                length: self.stated.identifier.terms.revolution,
            },
        };
        Axis {
            between: self.between,
            ..Axis::new(self.units().position(), way)
        }
    }

    /// These options with the way of a record whose positions are in a unit that nobody knows.
    pub(crate) fn along(mut self, samples: &[Logged]) -> Self {
        if self.motion_unit().axis().is_err() {
            let positions = || samples.iter().map(|sample| sample.position);
            let length = positions().fold(f64::NEG_INFINITY, f64::max)
                - positions().fold(f64::INFINITY, f64::min);
            if length > 0.0 {
                self.stated.identifier.terms.revolution = length;
            }
        }
        self
    }
}

/// Checks that the keys go together. `is_log`: they are a log's.
pub(super) fn check(scenario: &Options, is_log: bool) -> Result<(), Fault> {
    let physical = &scenario.physical;
    let stated = [
        (
            "physical.torque_constant",
            physical.torque_constant.is_some(),
        ),
        ("physical.inertia", physical.inertia.is_some()),
        ("physical.payload", physical.payload.is_some()),
    ];
    let mut stated = stated.iter().filter(|(_, is_stated)| *is_stated);
    let (first, second) = (stated.next(), stated.next());
    let unit = physical.command_unit;
    if let (Some((first, _)), Some((second, _))) = (first, second) {
        return Err(Fault::new(
            *second,
            format!("{first} already determines torques: state only one of them"),
        ));
    }
    if let (CommandUnit::NewtonMetre | CommandUnit::Newton, Some((key, _))) = (unit, first) {
        return Err(Fault::new(
            *key,
            format!(
                "a command in {} is already the torque: leave this out",
                unit.name()
            ),
        ));
    }
    if physical.payload.is_some() != physical.bare_gain.is_some() {
        return Err(Fault::new(
            "physical.payload",
            "payload and bare_gain must be stated together: the attached inertia, and [b, standard error] of the \
             result without it",
        ));
    }
    if let (Err(error), Some(_)) = (
        scenario.log_columns().motion_unit().axis(),
        physical.scale(),
    ) {
        let key = first.map_or("physical.command_unit", |(key, _)| *key);
        return Err(Fault::new(key, error.to_string()));
    }
    let is_angle = scenario.log.as_ref().is_some_and(|log| {
        !matches!(
            log.units.position,
            PositionUnit::Metre | PositionUnit::Millimetre
        )
    });
    let is_in_m = scenario.motion_unit() == MotionUnit::Stated(AxisKind::Linear) && !is_angle;
    let is_wrong = match unit {
        CommandUnit::Newton => is_angle,
        CommandUnit::NewtonMetre => is_in_m,
        _ => false,
    };
    if is_wrong && is_log {
        return Err(Fault::new(
            "physical.command_unit",
            "\"N\" belongs to an axis in m, \"Nm\" to one in rad: correct this or log.position_unit",
        ));
    }
    Ok(())
}
