//! What the user states of a log, as options.

use crate::scenario::{Column, LogSettings, LogUnits, PositionUnit, Scan, TimeUnit};

/// What the user states of a log: each option is the key of `[log]` or `[encoder]` of its name.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "program", derive(clap::Args))]
pub struct Stated {
    /// Column of the time, by name or number from 1; `none` if the rows are the samples.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub time: Option<String>,
    /// Unit of the time: s, ms, us, ns, samples or iso-8601.
    #[cfg_attr(feature = "program", arg(long, value_name = "UNIT", value_parser = time_unit))]
    pub time_unit: Option<TimeUnit>,
    /// Time from one sample to the next, s.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "S", allow_negative_numbers = true)
    )]
    pub sample_time: Option<f64>,
    /// Column of the measured position.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub position: Option<String>,
    /// Unit of the position: rad, deg, turns, counts, m or mm.
    #[cfg_attr(feature = "program", arg(long, value_name = "UNIT", value_parser = position_unit))]
    pub position_unit: Option<PositionUnit>,
    /// Position units for one of the column's; below 0 for the other direction.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "FACTOR", allow_negative_numbers = true)
    )]
    pub position_scale: Option<f64>,
    /// Period after which the position begins again, in its unit; 0 if it does not.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "PERIOD", allow_negative_numbers = true)
    )]
    pub wrap: Option<f64>,
    /// Counts of the encoder for a revolution, after fourfold evaluation.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "N", allow_negative_numbers = true)
    )]
    pub counts_per_rev: Option<f64>,
    /// Column of the command that acted.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub command: Option<String>,
    /// Command units for one of the column's; below 0 for the other direction.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "FACTOR", allow_negative_numbers = true)
    )]
    pub command_scale: Option<f64>,
    /// Column of the reference; `none` to leave it aside.
    #[cfg_attr(feature = "program", arg(long, value_name = "COLUMN"))]
    pub reference: Option<String>,
    /// Unit of the reference; that of the position by default.
    #[cfg_attr(feature = "program", arg(long, value_name = "UNIT", value_parser = position_unit))]
    pub reference_unit: Option<PositionUnit>,
    /// Reference units for one of the column's.
    #[cfg_attr(
        feature = "program",
        arg(long, value_name = "FACTOR", allow_negative_numbers = true)
    )]
    pub reference_scale: Option<f64>,
    /// The most missing samples in a row that straight lines bridge.
    #[cfg_attr(feature = "program", arg(long, value_name = "N"))]
    pub bridge_gaps: Option<u32>,
    /// A range of the log's time that is left out, s, FROM:TO. May be repeated.
    #[cfg_attr(feature = "program", arg(long, value_name = "FROM:TO", value_parser = range, allow_hyphen_values = true))]
    pub cut: Vec<[f64; 2]>,
    /// What follows where the scan of the log finds a contradiction: refuse or warn.
    #[cfg_attr(feature = "program", arg(long, value_name = "refuse|warn", value_parser = scan))]
    pub scan: Option<Scan>,
}

impl Stated {
    /// The settings of a log with this column of the position, as far as they are stated; the other columns and the
    /// units of time and position are not among them.
    pub(super) fn settings(&self, position: Column) -> LogSettings {
        let mut cut = self.cut.clone();
        cut.sort_by(|one, other| one[0].total_cmp(&other[0]));
        LogSettings {
            bridge: self.bridge_gaps.unwrap_or(0),
            sample_time: self.sample_time,
            cut,
            wrap: self.wrap,
            scan: self.scan.unwrap_or(Scan::Refuse),
            units: LogUnits {
                position_scale: self.position_scale.unwrap_or(1.0),
                reference_scale: self.reference_scale.unwrap_or(1.0),
                command_scale: self.command_scale.unwrap_or(1.0),
                counts_per_rev: self.counts_per_rev,
                ..LogUnits::SI
            },
            ..LogSettings::with_position(position)
        }
    }

    /// Takes the value of an option by its name, as the answer to a question is one.
    ///
    /// # Errors
    /// The allowed values.
    pub fn answer(&mut self, flag: &str, answer: &str) -> Result<(), String> {
        let number = || {
            let number = answer.parse().ok().filter(|number| f64::is_finite(*number));
            number.ok_or_else(|| "a number, as 0.05 or 5e-2".to_owned())
        };
        match flag {
            "time" => self.time = Some(answer.to_owned()),
            "position" => self.position = Some(answer.to_owned()),
            "command" => self.command = Some(answer.to_owned()),
            "reference" => self.reference = Some(answer.to_owned()),
            "time-unit" => self.time_unit = Some(time_unit(answer)?),
            "position-unit" => self.position_unit = Some(position_unit(answer)?),
            "reference-unit" => self.reference_unit = Some(position_unit(answer)?),
            "position-scale" => self.position_scale = Some(number()?),
            "command-scale" => self.command_scale = Some(number()?),
            "reference-scale" => self.reference_scale = Some(number()?),
            "sample-time" => self.sample_time = Some(number()?),
            "counts-per-rev" => self.counts_per_rev = Some(number()?),
            "wrap" => self.wrap = Some(number()?),
            "scan" => self.scan = Some(scan(answer)?),
            _ => return Err(format!("--{flag} is no option that takes one value")),
        }
        Ok(())
    }
}

/// One of some values by its name.
fn named<T: Copy>(all: &[T], name: fn(T) -> &'static str, word: &str) -> Result<T, String> {
    let found = all.iter().copied().find(|of| name(*of) == word);
    found.ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|of| name(*of)).collect();
        format!("one of {}", names.join(", "))
    })
}

fn time_unit(word: &str) -> Result<TimeUnit, String> {
    named(TimeUnit::ALL, TimeUnit::name, word)
}

fn position_unit(word: &str) -> Result<PositionUnit, String> {
    named(PositionUnit::ALL, PositionUnit::name, word)
}

fn scan(word: &str) -> Result<Scan, String> {
    named(Scan::ALL, Scan::name, word)
}

fn range(words: &str) -> Result<[f64; 2], String> {
    let range = words.split_once(':').and_then(|(from, to)| {
        let ends = [from.parse::<f64>().ok()?, to.parse::<f64>().ok()?];
        (ends[0].is_finite() && ends[0] < ends[1] && ends[1].is_finite()).then_some(ends)
    });
    range.ok_or_else(|| "two times in s, the earlier first, as 1.5:2".to_owned())
}
