//! The findings about a log in words, and its scenario.

use std::fmt::Write;

use super::Recognised;
use super::columns::{Chosen, Columns};
use super::name::Unit;
use super::position::{Reading, short};
use crate::log::Table;
use crate::scenario::{Column, PositionUnit, Scan, TimeUnit};

impl Columns {
    /// How many columns there are, and those that are left aside.
    pub(super) fn left_aside(&self, table: &Table) -> String {
        let count = table.columns.len();
        let mut text = format!("{count}, divided by {}s", table.separator);
        if !table.has_heading {
            text += ", without a heading: they go by number";
        }
        let used: Vec<_> = [Some(&self.position), Some(&self.command)]
            .into_iter()
            .chain([self.time.as_ref(), self.reference.as_ref()])
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

    pub(super) fn position_text(&self, reading: &Reading) -> String {
        let unit = reading.unit.name();
        let mut text = format!("{}, in {unit} {}", self.position.text(), reading.evidence);
        match (reading.step, reading.counts_per_rev) {
            (_, Some(counts)) if counts > 0.0 => {
                text += &format!("; the encoder has {counts} counts per revolution");
            }
            (Some(step), _) => text += &format!("; its smallest step is {} {unit}", short(step)),
            (None, _) => {}
        }
        if matches!(reading.unit, PositionUnit::Metre | PositionUnit::Millimetre) {
            text += "; a linear axis, for which rad is read as m";
        }
        text
    }

    /// Of a command that is multiplied by a scale.
    pub(super) fn command_text(&self, scale: f64) -> String {
        let unit = match self.command.named.unit {
            _ if (scale - 1.0).abs() > 0.0 => {
                format!("times {scale}, and b in rad/s² for one of the product")
            }
            Some(Unit::Command(unit)) => format!("in {unit}, and b in rad/s² per {unit}"),
            _ => "in its own unit, and b in rad/s² for one of it".to_owned(),
        };
        format!(
            "{}, {unit}; it is taken to be the whole command that acted",
            self.command.text()
        )
    }

    pub(super) fn reference_text(&self, unit: Option<PositionUnit>) -> String {
        let reference = self.reference.as_ref().map_or(String::new(), Chosen::text);
        match unit {
            Some(unit) => format!("{reference}, in {}; it only checks the log", unit.name()),
            None => format!("{reference}, in the unit of the position; it only checks the log"),
        }
    }
}

impl Chosen {
    fn text(&self) -> String {
        format!("column {}, {}", self.column, self.evidence)
    }
}

impl Recognised {
    /// The scenario with which `replay` identifies the log as it was recognised.
    #[must_use]
    pub fn scenario(&self, log: &str) -> String {
        let mut text = format!("# {} as `servo-id identify` took it:\n", one_line(log));
        for finding in &self.findings {
            let _ = writeln!(text, "#   {}: {}", finding.about, one_line(&finding.text));
        }
        text += "#\n#   servo-id replay LOG --scenario THIS.toml   identifies it again\n\n";
        if let Some(counts) = self.counts_per_rev {
            let _ = writeln!(text, "[encoder]\ncounts_per_rev = {counts:?}\n");
        }
        text += "[identifier]\nlaw = \"fit\"\n\n[log]\n";
        let settings = &self.settings;
        for (name, column) in [
            ("time", settings.time.as_ref()),
            ("reference", settings.reference.as_ref()),
            ("position", Some(&settings.position)),
            ("command", settings.command.as_ref()),
        ] {
            if let Some(column) = column {
                let _ = writeln!(text, "{name} = {}", value(column));
            }
        }
        let units = &settings.units;
        if settings.time.is_some() && units.time != TimeUnit::Second {
            let _ = writeln!(text, "time_unit = \"{}\"", units.time.name());
        }
        let _ = writeln!(text, "position_unit = \"{}\"", units.position.name());
        if let Some(unit) = units.reference.filter(|_| settings.reference.is_some()) {
            let _ = writeln!(text, "reference_unit = \"{}\"", unit.name());
        }
        for (name, scale) in [
            ("position_scale", units.position_scale),
            ("reference_scale", units.reference_scale),
            ("command_scale", units.command_scale),
        ] {
            if (scale - 1.0).abs() > 0.0 {
                let _ = writeln!(text, "{name} = {scale:?}");
            }
        }
        if let Some(sample_time) = settings.sample_time {
            let _ = writeln!(text, "sample_time = {sample_time:?}");
        }
        if settings.bridge > 0 {
            let _ = writeln!(text, "bridge_gaps = {}", settings.bridge);
        }
        if !settings.cut.is_empty() {
            let _ = writeln!(text, "cut = {:?}", settings.cut);
        }
        if let Some(wrap) = settings.wrap {
            let _ = writeln!(text, "wrap = {wrap:?}");
        }
        if settings.scan == Scan::Warn {
            text += "scan = \"warn\"\n";
        }
        text
    }
}

/// A column as TOML has it.
fn value(column: &Column) -> String {
    match column {
        Column::Number(number) => number.to_string(),
        // A string of JSON is one of TOML.
        Column::Named(name) => serde_json::Value::from(name.as_str()).to_string(),
    }
}

/// A text without what would end a comment.
fn one_line(text: &str) -> String {
    crate::nearest::shortened(text, 400)
}
