//! The keys of a log: columns, units, and ranges that are left out.

use std::fmt;

use super::Options;
use super::error::Fault;
use super::inner::InnerLoop;
use super::log_units::{LogQuantity, LogUnits, PositionUnit, TimeUnit};
use super::physical::CommandUnit;
use crate::column_reading::{ColumnReading, CommandReading, CommandSign, Reading};
use crate::motion_unit::{AxisKind, MotionUnit};

/// Which column of a log is what, and in which unit.
#[derive(Debug, Clone, PartialEq)]
pub struct LogSettings {
    /// Time. None: the rows are the samples, one after the other.
    pub time: Option<Column>,
    /// Reference position; a log with the command needs none.
    pub reference: Option<Column>,
    /// Measured position.
    pub position: Column,
    /// The command that acted, whatever it was made of. None: the declared controller's, computed
    /// again.
    pub command: Option<Column>,
    /// A known torque that acts on the joint beside the command, N·m (N on a linear axis).
    pub known_torque: Option<Column>,
    /// Measured velocity, which the servo's own position loop acts on.
    pub velocity: Option<Column>,
    /// The servo's own position loop, whose command follows from the reference as its goal.
    pub inner: Option<InnerLoop>,
    /// True if a position of zero is the same angle in every recording.
    pub absolute: bool,
    /// The longest gap, in missing samples, that may be bridged by straight lines.
    pub bridge: u32,
    /// The units of the columns.
    pub units: LogUnits,
    /// The stated sample time, s.
    pub sample_time: Option<f64>,
    /// Ranges of time that are left out, s, ascending.
    pub cut: Vec<[f64; 2]>,
    /// The period after which the position begins again, in the column's unit, zero for none. If it is not stated, it
    /// is found.
    pub wrap: Option<f64>,
    /// True if the column of the position is that of a velocity, whose integral is the position.
    pub is_velocity: bool,
}

/// A column of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Column {
    /// By its name in the heading.
    Named(String),
    /// By its number, from 1.
    Number(u32),
}

impl Column {
    /// A column by its name.
    #[must_use]
    pub fn named(name: &str) -> Self {
        Self::Named(name.to_owned())
    }
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(name) => f.write_str(name),
            Self::Number(number) => number.fmt(f),
        }
    }
}

impl LogSettings {
    /// The columns of the tool's own traces.
    pub const OWN_TIME: &str = "time_s";
    /// Reference position, rad.
    pub const OWN_REFERENCE: &str = "reference_rad";
    /// Measured position, rad.
    pub const OWN_POSITION: &str = "position_rad";
    /// The command that acted.
    pub const OWN_COMMAND: &str = "command";

    /// Those of a trace that the tool itself wrote.
    #[must_use]
    pub fn own() -> Self {
        Self {
            time: Some(Column::named(Self::OWN_TIME)),
            reference: Some(Column::named(Self::OWN_REFERENCE)),
            command: Some(Column::named(Self::OWN_COMMAND)),
            ..Self::with_position(Column::named(Self::OWN_POSITION))
        }
    }

    /// Those of a log of which only the position's column is stated.
    #[must_use]
    pub fn with_position(position: Column) -> Self {
        Self {
            time: None,
            reference: None,
            position,
            command: None,
            known_torque: None,
            velocity: None,
            inner: None,
            absolute: false,
            bridge: 0,
            units: LogUnits::SI,
            sample_time: None,
            cut: Vec::new(),
            wrap: None,
            is_velocity: false,
        }
    }

    /// The stated columns, time first.
    pub fn columns(&self) -> impl Iterator<Item = (LogQuantity, &Column)> {
        let columns = [
            (LogQuantity::Time, self.time.as_ref()),
            (LogQuantity::Reference, self.reference.as_ref()),
            (LogQuantity::Position, Some(&self.position)),
            (LogQuantity::Command, self.command.as_ref()),
            (LogQuantity::KnownTorque, self.known_torque.as_ref()),
            (LogQuantity::Velocity, self.velocity.as_ref()),
        ];
        (columns.into_iter()).filter_map(|(quantity, column)| Some((quantity, column?)))
    }

    /// True for a time, s, in a range that is left out.
    #[must_use]
    pub fn leaves_out(&self, time: f64) -> bool {
        self.cut
            .iter()
            .any(|[from, to]| (*from..=*to).contains(&time))
    }

    /// True if a range is left out between two times, s.
    #[must_use]
    pub fn leaves_out_between(&self, from: f64, to: f64) -> bool {
        self.cut.iter().any(|[low, high]| *high > from && *low < to)
    }

    /// The unit of its positions as they are read.
    #[must_use]
    pub fn motion_unit(&self) -> MotionUnit {
        match self.units.position {
            PositionUnit::Metre | PositionUnit::Millimetre => MotionUnit::Stated(AxisKind::Linear),
            PositionUnit::Count if self.units.counts_per_rev.is_none() => MotionUnit::Count,
            PositionUnit::Own if self.is_velocity => MotionUnit::OwnVelocity,
            PositionUnit::Own => MotionUnit::Own,
            _ => MotionUnit::Stated(AxisKind::Rotary),
        }
    }

    /// True if the rows state the length of a sample.
    #[must_use]
    pub fn has_sample_time(&self) -> bool {
        self.time.is_some() && self.units.time != TimeUnit::Sample
    }

    /// The first other unit of log.time in which a time from one sample to the next, s, `fits`.
    pub(crate) fn other_time_unit(
        &self,
        step: f64,
        fits: impl Fn(f64) -> bool,
    ) -> Option<TimeUnit> {
        self.time
            .as_ref()
            .filter(|_| self.units.time != TimeUnit::Stamp)?;
        let own = self.units.time.seconds()?;
        let others = TimeUnit::ALL.iter().copied();
        others
            .filter(|unit| ![self.units.time, TimeUnit::Stamp].contains(unit))
            .find(|unit| unit.seconds().is_some_and(|other| fits(step * other / own)))
    }

    /// Keeps ranges of time to be left out, in their order.
    pub(super) fn leave_out(&mut self, ranges: &[[f64; 2]]) -> Result<(), String> {
        let ranges = in_order(ranges);
        for pair in ranges.windows(2) {
            let ([from, to], [next, end]) = (pair[0], pair[1]);
            if next <= to {
                return Err(format!(
                    "[{from}, {to}] and [{next}, {end}] overlap: write [{from}, {}]",
                    to.max(end)
                ));
            }
        }
        self.cut = ranges;
        Ok(())
    }
}

/// A few ranges in the order in which they begin.
pub(crate) fn in_order(ranges: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted: Vec<[f64; 2]> = Vec::with_capacity(ranges.len());
    for range in ranges {
        let place = sorted.partition_point(|before| before[0] <= range[0]);
        sorted.insert(place, *range);
    }
    sorted
}

impl Options {
    /// The columns of a log to replay: those of the tool's own traces unless others are stated.
    #[must_use]
    pub fn log_columns(&self) -> LogSettings {
        let mut log = self.log.clone().unwrap_or_else(LogSettings::own);
        log.units.counts_per_rev = self.counts_per_rev;
        log.units.torque_constant = self.physical.known_torque_constant();
        log.inner = self.inner;
        log
    }

    /// How the columns of a log are read, as recognised or as stated; none without a log.
    #[must_use]
    pub(crate) fn log_reading(&self) -> Option<Reading> {
        const STATED: &str = "as stated";
        let stated = || {
            let log = self.log.as_ref()?;
            let column = |column: Option<&Column>, unit: Option<&str>, factor: f64| ColumnReading {
                column: column.map(ToString::to_string),
                unit: unit.map(str::to_owned),
                factor,
                evidence: STATED.to_owned(),
            };
            let units = &log.units;
            let position = Some(units.position.name());
            let position = position.filter(|_| units.position != PositionUnit::Own);
            let unit = Some(self.physical.command_unit.name());
            let unit = unit.filter(|_| self.physical.command_unit != CommandUnit::Other);
            let scale = units.command_scale;
            let command = log.command.as_ref().map(|command| CommandReading {
                of: column(Some(command), unit, scale.abs()),
                sign: match scale < 0.0 {
                    true => CommandSign::Stated,
                    false => CommandSign::AsLogged,
                },
            });
            Some(Reading {
                time: column(log.time.as_ref(), Some(units.time.name()), 1.0),
                position: column(Some(&log.position), position, units.position_scale),
                command,
                assumed: Vec::new(),
            })
        };
        self.reading.clone().or_else(stated)
    }

    /// The sample time that a log must have, s; none where only the log knows it.
    #[must_use]
    pub fn log_sample_time(&self) -> Option<f64> {
        let declared = self.stated.controller.is_some();
        let stated = self.log.as_ref().and_then(|log| log.sample_time);
        declared.then_some(self.sample_time()).or(stated)
    }
}

/// Checks that columns, units and ranges of a log go together.
pub(super) fn check(scenario: &Options) -> Result<(), Fault> {
    let log = scenario.log_columns();
    if !log.has_sample_time() && scenario.log_sample_time().is_none() {
        let why = match log.time {
            Some(_) => "stamps in samples",
            None => "rows without log.time",
        };
        return Err(Fault::new(
            "log.sample_time",
            format!("{why} do not give the sample time: state it"),
        ));
    }
    if let (Some(stated), Some(needed)) = (log.sample_time, scenario.log_sample_time())
        && (stated / needed - 1.0).abs() > 1e-6
    {
        return Err(Fault::new(
            "log.sample_time",
            format!(
                "the log has one sample time, but it is {stated} s here and {needed} s in [controller]"
            ),
        ));
    }
    let columns: Vec<_> = log.columns().collect();
    for (place, (quantity, column)) in columns.iter().enumerate() {
        if let Some((other, _)) = columns[..place].iter().find(|(_, other)| other == column) {
            return Err(Fault::new(
                quantity.key(),
                format!(
                    "{column} is already {}: each quantity needs its own column",
                    other.key()
                ),
            ));
        }
    }
    let (unit, position) = (log.units.reference, log.units.position);
    if let Some(unit) = unit.filter(|unit| *unit != position) {
        let in_its_unit = LogSettings {
            units: LogUnits {
                position: unit,
                ..log.units
            },
            ..log.clone()
        };
        let units = [log.motion_unit(), in_its_unit.motion_unit()];
        if units.iter().any(|unit| unit.axis().is_err()) {
            return Err(Fault::new(
                "log.reference_unit",
                format!(
                    "\"{}\" is in no known relation to the position's \"{}\": state log.position_unit, for counts with \
                     encoder.counts_per_rev",
                    unit.name(),
                    position.name()
                ),
            ));
        }
    }
    for (key, scale) in [
        ("log.position_scale", log.units.position_scale),
        ("log.reference_scale", log.units.reference_scale),
        ("log.command_scale", log.units.command_scale),
    ] {
        /// Scales between which a unit can be a unit of anything.
        const SCALES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;
        if !SCALES.contains(&scale.abs()) {
            return Err(Fault::new(
                key,
                format!(
                    "{scale} is not allowed: a scale is from 1e-12 to 1e12, or the same below 0"
                ),
            ));
        }
    }
    check_known_torque(scenario, &log)?;
    let controller = scenario.stated.controller.as_ref();
    if !log.cut.is_empty() && log.command.is_none() && controller.is_some_and(|pid| pid.ki > 0.0) {
        return Err(Fault::new(
            "log.cut",
            "without log.command the declared controller's integral is unknown after a range that is left out: split \
             the file, or record the command",
        ));
    }
    Ok(())
}

/// Checks that a known torque can be added to a command.
fn check_known_torque(scenario: &Options, log: &LogSettings) -> Result<(), Fault> {
    let fault = if log.known_torque.is_none() {
        return Ok(());
    } else if log.units.torque_constant.is_none() {
        "the column is in N·m, but the torque of a command unit is not stated: state physical.torque_constant, or \
         physical.command_unit = \"Nm\""
    } else if scenario.stated.controller.is_some() || (log.command.is_none() && log.inner.is_none())
    {
        "it is added to a recorded command: state log.command, or the goal with [inner], and no [controller]"
    } else {
        return Ok(());
    };
    Err(Fault::new("log.known_torque", fault))
}
