//! The contents of a log without a scenario: columns, units, sample time, encoder; and the scenario that declares them.
//!
//! Each finding has its evidence: an option, the name of a column, or its numbers. Which column commands which is judged by
//! the motion. A [`Question`] is asked only where two readings explain it alike.

mod columns;
mod log_options;
mod name;
mod position;
mod question;
mod text;
mod unit;

use crate::column_reading::Reading;
use crate::log::{LogError, Table};
use crate::scenario::{InnerLoop, LogSettings, PhysicalSettings, TimeUnit};

use columns::{Candidates, Chosen};
use unit::Unit;

pub use log_options::LogOptions;
pub use question::Question;

/// A recognised log.
#[derive(Debug, Clone, PartialEq)]
pub struct Recognised {
    /// Columns and units.
    pub settings: LogSettings,
    /// Counts of a revolution, where an encoder is known.
    pub counts_per_rev: Option<f64>,
    /// The servo's own position loop, of a log of goals.
    pub inner: Option<InnerLoop>,
    /// Unit of the command and scale of torques.
    pub physical: PhysicalSettings,
    /// Each finding with its evidence.
    pub findings: Vec<Finding>,
    /// How the columns are read.
    pub reading: Reading,
}

/// A finding about a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Its subject, one word.
    pub about: &'static str,
    /// The finding with its evidence, without an end.
    pub text: String,
}

/// Why a log was not recognised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unrecognised {
    /// It cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// It does not show all.
    #[error("{}", .0.iter().map(|open| &*open.text).collect::<Vec<_>>().join("; "))]
    Unknown(Vec<Question>),
}

impl From<Question> for Unrecognised {
    fn from(question: Question) -> Self {
        Self::Unknown(vec![question])
    }
}

/// Recognises the columns of a log.
///
/// # Errors
/// A log of which nothing can be known, or the questions that it leaves open.
pub fn recognise(table: &Table, stated: &LogOptions) -> Result<Recognised, Unrecognised> {
    let of_file = |fault: &str| LogError::of_file(&table.path, fault);
    if table.rows() < 3 {
        let fault = match table.rows() {
            2 => "the log has 2 rows: a motion needs hundreds of samples, one row each",
            _ => "the log has one row: a motion needs hundreds of samples, one row each",
        };
        return Err(of_file(fault).into());
    }
    if table.columns.len() < 2 {
        let fault = format!(
            "the log has one column (separator: {}): it must have position and command",
            table.separator.unwrap_or("comma")
        );
        return Err(of_file(&fault).into());
    }
    let candidates = Candidates::of(table);
    let clock = candidates.clock(stated)?;
    if stated.sample_time.is_none() {
        let text = match (&clock.chosen, clock.unit) {
            (None, _) => {
                "the log has no time column: state the time from one row to the next, in s"
                    .to_owned()
            }
            (Some(time), TimeUnit::Sample) => {
                format!(
                    "{} counts samples: state the time of one sample, in s",
                    time.column
                )
            }
            _ => String::new(),
        };
        if !text.is_empty() {
            let flag = "sample-time";
            return Err(Question { flag, text }.into());
        }
    }
    let columns = candidates
        .find(stated, &clock)
        .map_err(Unrecognised::Unknown)?;
    let inner = (columns.command.is_none()).then(|| stated.inner());
    let mut settings = stated.settings(columns.position.column.clone());
    let column = |chosen: &Option<Chosen>| chosen.as_ref().map(|chosen| chosen.column.clone());
    settings.time = column(&clock.chosen);
    settings.units.time = clock.unit;
    settings.command = column(&columns.command);
    settings.velocity = column(&columns.velocity);
    settings.known_torque = column(&columns.known_torque);
    settings.is_velocity = columns.is_velocity;
    if stated.command_scale.is_none() {
        let sign = if columns.is_reversed { -1.0 } else { 1.0 };
        settings.units.command_scale = sign * columns.command_part(stated.command_unit);
    }
    let measured = &table.columns[columns.position.index];
    let position = position::read(
        measured,
        &columns.position.named,
        columns.is_velocity,
        stated,
    );
    settings.units.position = position.unit;
    settings.units.position_scale *= position.scale;
    let counts_per_rev = position.counts_per_rev;
    settings.units.counts_per_rev = counts_per_rev;
    let motion_unit = settings.motion_unit();
    let mut findings = Vec::new();
    let mut say = |about, text| findings.push(Finding { about, text });
    say("columns", columns.left_aside(table));
    say("time", clock.text(stated.sample_time.unwrap_or(f64::NAN)));
    say("position", columns.position_text(&position));
    let (scale, is_gain_stated) = (settings.units.command_scale, stated.kp.is_some());
    let scale = if columns.is_reversed {
        scale.abs()
    } else {
        scale
    };
    say(
        "command",
        columns.command_text(scale, inner.as_ref(), is_gain_stated, motion_unit),
    );
    if let Some(reference) = &columns.reference {
        settings.reference = Some(reference.column.clone());
        let own = (settings.units.position, position.scale);
        let other = match reference.named.unit {
            Some(Unit::Position(unit, scale)) => Some((unit, scale)),
            _ => None,
        };
        let other = other.filter(|other| stated.reference_unit.is_none() && *other != own);
        settings.units.reference = stated.reference_unit.or(other.map(|(unit, _)| unit));
        settings.units.reference_scale *= other.map_or(1.0, |(_, scale)| scale);
        say(
            "reference",
            columns.reference_text(settings.units.reference),
        );
    }
    if let Some(torque) = &columns.known_torque {
        say(
            "torque",
            format!(
                "column {}, as stated; it is added to the command",
                torque.column
            ),
        );
    }
    let unit = columns.command_unit(&settings.units, stated);
    let physical = stated.physical(unit.filter(|_| motion_unit.axis().is_ok()));
    if let Some(text) = text::physical(&physical) {
        say("units", text);
    }
    Ok(Recognised {
        reading: columns.reading(&clock, &position, &settings, &physical, stated),
        physical,
        inner,
        settings,
        counts_per_rev,
        findings,
    })
}
