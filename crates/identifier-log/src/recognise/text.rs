//! The findings about a log in words, and its scenario.

use std::fmt::Write;

use identifier_core::parameters::Unknown;

use super::LogOptions;
use super::Recognised;
use super::columns::{Chosen, Clock, Columns};
use super::position::{PositionReading, short};
use super::unit::Unit;
use crate::column_reading::{ColumnReading, CommandReading, CommandSign, Reading};
use crate::log::Table;
use crate::motion_unit::MotionUnit;
use crate::physical::Scale;
use crate::scenario::{
    CommandUnit, Estimator, Fault, InnerLoop, LogSettings, Options, PhysicalSettings, PositionUnit,
    TimeUnit,
};

impl Clock {
    pub(super) fn text(&self, sample_time: f64) -> String {
        let Some(time) = &self.chosen else {
            return format!("no column: one row every {sample_time} s, as stated");
        };
        let column = time.text();
        match self.unit {
            TimeUnit::Sample => format!("{column}, a counter of samples"),
            unit => format!("{column}, in {} ({})", unit.name(), self.evidence),
        }
    }
}

impl Columns {
    /// How many columns there are, and those that are left aside.
    pub(super) fn left_aside(&self, table: &Table) -> String {
        let count = table.columns.len();
        let mut text = match table.separator {
            Some(separator) => format!("{count}, separated by {separator}s"),
            None => count.to_string(),
        };
        if !table.has_heading {
            text += ", without a heading: state them by number";
        }
        let used: Vec<_> = [Some(&self.position), self.command.as_ref()]
            .into_iter()
            .chain([
                self.time.as_ref(),
                self.reference.as_ref(),
                self.velocity.as_ref(),
                self.known_torque.as_ref(),
            ])
            .flatten()
            .map(|chosen| chosen.index)
            .collect();
        let others: Vec<_> = (table.columns.iter().zip(0..))
            .filter(|(_, index)| !used.contains(index))
            .map(|(column, index)| match column.name.as_str() {
                "" => (index + 1).to_string(),
                name => name.to_owned(),
            })
            .collect();
        if !others.is_empty() {
            let others = crate::nearest::shortened(&others.join(", "), 60);
            text += &format!("; not used: {others}");
        }
        text
    }

    /// How the columns are read.
    pub(super) fn reading(
        &self,
        clock: &Clock,
        position: &PositionReading,
        settings: &LogSettings,
        physical: &PhysicalSettings,
        stated: &LogOptions,
    ) -> Reading {
        let column =
            |chosen: &Chosen, unit: Option<&str>, factor: f64, evidence: &str| ColumnReading {
                column: Some(chosen.column.to_string()),
                unit: unit.map(str::to_owned),
                factor,
                evidence: match evidence {
                    "" => chosen.evidence.clone(),
                    evidence => format!("{}; unit {evidence}", chosen.evidence),
                },
            };
        let time = match &clock.chosen {
            Some(time) => column(time, Some(clock.unit.name()), 1.0, clock.evidence),
            None => ColumnReading {
                column: None,
                unit: Some(TimeUnit::Second.name().to_owned()),
                factor: stated.sample_time.unwrap_or(1.0),
                evidence: "as stated".to_owned(),
            },
        };
        let units = &settings.units;
        let is_unit_stated = position.unit != PositionUnit::Own;
        let scale = units.command_scale;
        let command = self.command.as_ref().map(|command| {
            let unit = match physical.command_unit {
                // The unit of a product is the column's no more.
                CommandUnit::Other => self.named_unit(scale),
                unit => Some(unit.name()),
            };
            CommandReading {
                of: column(command, unit, scale.abs(), ""),
                sign: match (scale < 0.0, stated.command_scale.is_some()) {
                    (false, _) => CommandSign::AsLogged,
                    (true, true) => CommandSign::Stated,
                    (true, false) => CommandSign::Inferred,
                },
            }
        });
        let assumed = clock.is_assumed.then(|| {
            format!(
                "the unit of the time, {}, is {}: --time-unit",
                clock.unit.name(),
                clock.evidence
            )
        });
        Reading {
            position: column(
                &self.position,
                is_unit_stated.then(|| position.unit.name()),
                units.position_scale,
                position.evidence,
            ),
            assumed: assumed.into_iter().collect(),
            time,
            command,
        }
    }

    pub(super) fn position_text(&self, reading: &PositionReading) -> String {
        let mut text = self.position.text();
        let (unit, evidence) = (reading.name(), reading.evidence);
        text += if self.is_velocity {
            ", a velocity in "
        } else {
            ", in "
        };
        if (reading.scale - 1.0).abs() > 0.0 {
            text += &format!("times {} ", short(reading.scale));
        }
        text += unit;
        if self.is_velocity && reading.unit != PositionUnit::Own {
            text += " per s";
        }
        text += &format!(" ({evidence})");
        if reading.unit == PositionUnit::Count && reading.counts_per_rev.is_none() {
            text += "; nobody states how many make a revolution: --counts-per-rev";
        }
        match (reading.step, reading.counts_per_rev) {
            (_, Some(counts)) if counts > 0.0 => {
                text += &format!("; the encoder has {counts} counts per revolution");
            }
            (Some(step), _) => text += &format!("; its smallest step is {}", short(step)),
            (None, _) => {}
        }
        if matches!(reading.unit, PositionUnit::Metre | PositionUnit::Millimetre) {
            text += "; a linear axis: read m for rad";
        }
        text
    }

    /// The text of a command that is multiplied by a scale, or of one from an inner loop.
    pub(super) fn command_text(
        &self,
        scale: f64,
        inner: Option<&InnerLoop>,
        is_gain_stated: bool,
        motion_unit: MotionUnit,
    ) -> String {
        let own = motion_unit.of(Unknown::Coulomb);
        let Some(command) = &self.command else {
            let (kp, kd) = inner.map_or((f64::NAN, f64::NAN), |inner| (inner.kp, inner.kd));
            let unknown = if is_gain_stated {
                ""
            } else {
                "; its gain is not stated, so b includes that gain"
            };
            return format!(
                "computed by the servo's own loop: {kp} (goal − position) − {kd} velocity; b in {own} per unit of \
                 it{unknown}"
            );
        };
        let is_scaled = (scale - 1.0).abs() > 0.0;
        let times = if is_scaled {
            format!("times {scale}, ")
        } else {
            String::new()
        };
        let unit = match self.named_unit(scale) {
            Some(unit) => format!("{times}in {unit}; b in {own} per {unit}"),
            None if is_scaled => format!("times {scale}; b in {own} per unit of the product"),
            None if command.named.unit == Some(Unit::Doubtful) => {
                format!("in a unit that is not known (--command-unit); b in {own} per unit of it")
            }
            None => format!("in its own unit; b in {own} per unit of it"),
        };
        let mut text = format!(
            "{}, {unit}; assumed to be the total command that acted",
            command.text()
        );
        if self.is_reversed {
            text += "; its sign is opposite to the motion and is inverted";
        }
        if let Some(next) = &self.next {
            text += &format!("; {next}");
        }
        text
    }

    pub(super) fn reference_text(&self, unit: Option<PositionUnit>) -> String {
        let reference = self.reference.as_ref().map_or(String::new(), Chosen::text);
        let unit = unit.map_or("the unit of the position", PositionUnit::name);
        let purpose = match &self.command {
            Some(_) => "for plots only",
            None => "it is the goal of the servo's own loop",
        };
        format!("{reference}, in {unit}; {purpose}")
    }
}

/// The unit of the command and the scale of torques, where the result is in physical units by them.
pub(super) fn physical(settings: &PhysicalSettings) -> Option<String> {
    Some(match (settings.command_unit, settings.scale()?) {
        (CommandUnit::NewtonMetre, _) => {
            "the command is in Nm and assumed to act at the joint, so the result has inertia and friction \
             (--command-unit other: ratios only)"
                .to_owned()
        }
        (CommandUnit::Newton, _) => {
            "the command is in N, so the result has mass and friction".to_owned()
        }
        (_, Scale::TorqueConstant(constant)) => {
            format!("torque constant as stated: {constant} N·m per command unit at the joint (N on a linear axis)")
        }
        (_, Scale::Inertia(inertia)) => {
            format!("total inertia as stated: {inertia} kg·m² (kg on a linear axis)")
        }
        (_, Scale::Payload { .. } | Scale::Ratios) => return None,
    })
}

impl Chosen {
    fn text(&self) -> String {
        format!("column {} ({})", self.column, self.evidence)
    }
}

impl Recognised {
    /// The options that identify the recognised log.
    ///
    /// # Errors
    /// The key that is not allowed.
    pub fn options(&self) -> Result<Options, Fault> {
        self.stated().checked()
    }

    fn stated(&self) -> Options {
        let mut options = Options::blank();
        options.identifier.set_estimator(Estimator::Fit);
        (options.counts_per_rev, options.inner) = (self.counts_per_rev, self.inner);
        options.physical = self.physical;
        options.reading = Some(self.reading.clone());
        let mut settings = self.settings.clone();
        // The encoder's, which the options have.
        settings.units.counts_per_rev = None;
        options.log = Some(settings);
        options
    }

    /// The scenario that identifies the recognised log.
    #[must_use]
    pub fn scenario(&self, log: &str) -> String {
        let mut text = format!("# {} as `servo-id identify` took it:\n", one_line(log));
        for finding in &self.findings {
            let _ = writeln!(text, "#   {}: {}", finding.about, one_line(&finding.text));
        }
        text += "#\n#   servo-id identify LOG --scenario THIS.toml   identifies it again\n\n";
        text + &self.stated().text()
    }
}

/// A text without what would end a comment.
fn one_line(text: &str) -> String {
    crate::nearest::shortened(text, 400)
}
