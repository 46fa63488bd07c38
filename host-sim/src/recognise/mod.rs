//! The contents of a log without a scenario: columns, units, sample time, encoder; and the scenario that declares them.
//!
//! Each finding has its evidence: an option, the name of a column, or its numbers. Where there is none, a
//! [`Question`] names the option that answers it; nothing is guessed that the answer of an identification depends on.

mod columns;
mod name;
mod position;
mod stated;
mod text;
mod time;

use std::path::Path;

use crate::log::{LogError, Table, Times};
use crate::scenario::{InnerLoop, LogSettings, PhysicalSettings, TimeUnit};

use columns::Columns;
use name::Unit;
use time::Spacing;

pub use stated::Stated;

/// A log as it was recognised.
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
}

/// A finding about a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Its subject, one word.
    pub about: &'static str,
    /// The finding with its evidence, without an end.
    pub text: String,
}

/// A fact that a log does not show and its user knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// The option that answers it.
    pub flag: &'static str,
    /// The unknown fact, and the allowed answers.
    pub text: String,
}

/// Why a log was not recognised.
#[derive(Debug, Clone, PartialEq)]
pub enum Unrecognised {
    /// It cannot be read.
    Log(LogError),
    /// It does not show all.
    Unknown(Vec<Question>),
}

impl From<LogError> for Unrecognised {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

impl From<Question> for Unrecognised {
    fn from(question: Question) -> Self {
        Self::Unknown(vec![question])
    }
}

/// Recognises a `.csv` or `.csv.gz` log.
///
/// # Errors
/// A log that cannot be read, or what it does not show.
pub fn recognise(path: &Path, stated: &Stated) -> Result<Recognised, Unrecognised> {
    let table = Table::read(path)?;
    if table.rows < 2 {
        let fault = match (table.rows, table.has_heading) {
            (0, true) => "the log has a heading and no samples: record the motion of the servo",
            _ => "the log has one row: a motion takes hundreds of samples, a row each",
        };
        return Err(LogError::of_file(path, fault).into());
    }
    if table.columns.len() < 2 {
        let fault = format!(
            "the log has one column (a {} divides columns): it must have position and command",
            table.separator
        );
        return Err(LogError::of_file(path, &fault).into());
    }
    let columns = Columns::find(&table, stated).map_err(Unrecognised::Unknown)?;
    let mut findings = vec![Finding {
        about: "columns",
        text: columns.left_aside(&table),
    }];
    let mut questions = Vec::new();
    let inner = stated.inner().unwrap_or_else(|question| {
        questions.push(question);
        None
    });
    let mut settings = stated.settings(columns.position.column.clone());
    settings.command = columns
        .command
        .as_ref()
        .map(|command| command.column.clone());
    settings.velocity = columns
        .velocity
        .as_ref()
        .map(|velocity| velocity.column.clone());
    let position = position::read(
        &table.columns[columns.position.index],
        &columns.position,
        stated,
    );
    let counts_per_rev = match &position {
        Ok(reading) => {
            settings.units.position = reading.unit;
            settings.units.counts_per_rev = reading.counts_per_rev.filter(|counts| *counts > 0.0);
            settings.units.counts_per_rev
        }
        Err(question) => {
            questions.push(question.clone());
            None
        }
    };
    let time = match &columns.time {
        None => {
            if stated.sample_time.is_none() {
                questions.push(Question {
                    flag: "sample-time",
                    text: "no column is the time: state how many seconds pass from one row to the next"
                        .to_owned(),
                });
            }
            None
        }
        Some(time) => match time::unit(&table, time, stated) {
            Ok((unit, evidence)) => Some((time, unit, evidence)),
            Err(question) => {
                questions.push(question);
                None
            }
        },
    };
    if let Some((time, TimeUnit::Sample, _)) = time
        && stated.sample_time.is_none()
    {
        questions.push(Question {
            flag: "sample-time",
            text: format!(
                "{} counts samples: state how many seconds one lasts",
                time.column
            ),
        });
    }
    if !questions.is_empty() {
        return Err(Unrecognised::Unknown(questions));
    }
    match time {
        Some((time, unit, evidence)) => {
            settings.time = Some(time.column.clone());
            settings.units.time = unit;
            findings.push(take_stamps(path, &mut settings, stated, evidence)?);
        }
        None => findings.push(Finding {
            about: "time",
            text: format!(
                "no column: the rows are {} s apart as stated",
                stated.sample_time.unwrap_or(f64::NAN)
            ),
        }),
    }
    // A cell that cannot be read is named before.
    position::check(path, &table, &columns.position)?;
    if let Ok(reading) = position {
        findings.push(Finding {
            about: "position",
            text: columns.position_text(&reading),
        });
    }
    findings.push(Finding {
        about: "command",
        text: columns.command_text(settings.units.command_scale, inner.as_ref()),
    });
    if let Some(reference) = &columns.reference {
        settings.reference = Some(reference.column.clone());
        settings.units.reference = stated.reference_unit.or(match reference.named.unit {
            Some(Unit::Position(unit)) if unit != settings.units.position => Some(unit),
            _ => None,
        });
        findings.push(Finding {
            about: "reference",
            text: columns.reference_text(settings.units.reference),
        });
    }
    let physical = stated.physical(columns.command_unit(&settings.units, stated));
    findings.extend(text::physical(&physical).map(|text| Finding {
        about: "units",
        text,
    }));
    Ok(Recognised {
        physical,
        inner,
        settings,
        counts_per_rev,
        findings,
    })
}

/// Takes the stamps of a whole log: gaps are bridged or left out, stamps that are too coarse left aside.
fn take_stamps(
    path: &Path,
    settings: &mut LogSettings,
    stated: &Stated,
    evidence: &'static str,
) -> Result<Finding, LogError> {
    let column = settings.time.clone();
    let column = column.map_or(String::new(), |column| column.to_string());
    let unit = settings.units.time.name();
    let finding = |text: String| Finding {
        about: "time",
        text,
    };
    if settings.units.time == TimeUnit::Sample {
        let text = format!("column {column}, a counter of samples, {evidence}");
        return Ok(finding(text));
    }
    let times = Times::read(path, settings)?;
    let mut text = format!("column {column}, in {unit} {evidence}");
    match time::spacing(&times) {
        Spacing::Backwards => {
            let fault = "time goes back from row to row, as of a log whose last row is the first: sort its rows by time";
            return Err(LogError::of_file(path, fault));
        }
        Spacing::Still => {
            let fault = format!(
                "the time is the same in all rows of column {column}: state another column as log.time, or no log.time \
                 and log.sample_time"
            );
            return Err(LogError::of_file(path, &fault));
        }
        Spacing::Lossy(share) if stated.sample_time.is_none() && stated.bridge_gaps.is_none() => {
            let fault = format!(
                "rows are missing before {:.0} % of the rows, as a sample lasts {} s: record every sample; or state \
                 log.bridge_gaps, or log.sample_time if the stamps are rounded",
                100.0 * share,
                position::short(times.step)
            );
            return Err(LogError::of_file(path, &fault));
        }
        Spacing::Lossy(_) => {}
        Spacing::Coarse(step) => {
            let step = stated.sample_time.unwrap_or(step);
            text += &format!(
                "; its stamps are too coarse to divide the rows, which are taken to be {} s apart",
                position::short(step)
            );
            settings.sample_time = Some(step);
            settings.time = None;
        }
        Spacing::Stamped { bridge, cut } => {
            text += &format!("; a sample lasts {} s", position::short(times.step));
            if bridge > 0 && stated.bridge_gaps.is_none() {
                settings.bridge = bridge;
                text += &format!("; gaps of up to {bridge} samples are bridged");
            }
            if !cut.is_empty() && stated.cut.is_empty() && settings.bridge <= bridge {
                text += &match cut.len() {
                    1 => "; it stops at a longer gap and begins again behind".to_owned(),
                    gaps => {
                        format!("; it stops at {gaps} longer gaps and begins again behind each")
                    }
                };
                settings.cut = cut;
            }
        }
    }
    Ok(finding(text))
}
