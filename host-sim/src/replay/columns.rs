//! Where the columns of a log stand, and what their numbers become.

use std::path::Path;

use super::cell::{Decimals, is_words};
use super::error::{LogError, shortened};
use crate::scenario::{Column, LogSettings};

/// The largest number that is taken for a measurement, s, rad or command units.
const LARGEST: f64 = 1e12;

/// A column.
#[derive(Debug, Clone)]
pub(super) struct Place {
    index: usize,
    /// As messages call it.
    pub(super) name: String,
    /// SI units for one of the column's.
    scale: f64,
}

/// The columns of a log that are read.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// None: the rows are the samples.
    pub(super) time: Option<Place>,
    pub(super) reference: Option<Place>,
    pub(super) position: Place,
    pub(super) command: Option<Place>,
    pub(super) injection: Option<Place>,
}

impl Columns {
    /// Finds them in the first row, which is the heading on this line; a sample lasts `sample_time`, s.
    ///
    /// # Errors
    /// The column that is not there, or there twice.
    pub(super) fn find(
        path: &Path,
        line: u64,
        first: &csv::ByteRecord,
        settings: &LogSettings,
        sample_time: f64,
    ) -> Result<Self, LogError> {
        let heading: Vec<_> = first
            .iter()
            .map(|name| String::from_utf8_lossy(name.trim_ascii()).into_owned())
            .collect();
        let place = |column: &Column, scale: f64| {
            let index = index_of(column, &heading)
                .map_err(|fault| LogError::of_line(path, line, Some(&column.to_string()), fault))?;
            Ok(Place {
                index,
                name: column.to_string(),
                scale,
            })
        };
        let optional = |column: &Option<Column>, scale: f64| {
            column
                .as_ref()
                .map(|column| place(column, scale))
                .transpose()
        };
        let units = &settings.units;
        Ok(Self {
            time: optional(&settings.time, units.seconds(sample_time))?,
            reference: optional(&settings.reference, units.reference())?,
            position: place(&settings.position, units.position())?,
            command: optional(&settings.command, units.command_scale)?,
            injection: optional(&settings.injection, units.command_scale)?,
        })
    }

    fn all(&self) -> impl Iterator<Item = &Place> {
        [
            self.time.as_ref(),
            self.reference.as_ref(),
            Some(&self.position),
            self.command.as_ref(),
            self.injection.as_ref(),
        ]
        .into_iter()
        .flatten()
    }

    /// Whether a row has words in all of these columns, and in one of them some: then it is no sample,
    /// but a heading, or says the units.
    pub(super) fn are_words(&self, row: &csv::ByteRecord) -> bool {
        let cell = |place: &Place| row.get(place.index).unwrap_or_default();
        self.all().all(|place| is_words(cell(place)))
            && self.all().any(|place| !cell(place).trim_ascii().is_empty())
    }

    /// What a row has in these columns.
    pub(super) fn words(&self, row: &csv::ByteRecord) -> String {
        let cells = self.all().map(|place| {
            let cell = row.get(place.index).unwrap_or_default();
            String::from_utf8_lossy(cell.trim_ascii()).into_owned()
        });
        shortened(&cells.collect::<Vec<_>>().join(", "))
    }
}

impl Place {
    /// What a row has in this column, SI.
    ///
    /// # Errors
    /// Why it is not allowed.
    pub(super) fn number(
        &self,
        row: &csv::ByteRecord,
        line: u64,
        decimals: &mut Decimals,
    ) -> Result<f64, String> {
        let cell = row.get(self.index).unwrap_or_default();
        let refused = |why: String| {
            let cell = shortened(&String::from_utf8_lossy(cell.trim_ascii()));
            format!(
                "\"{cell}\" is not allowed: {why}; correct it, or leave its time out with log.cut"
            )
        };
        let number = self.scale * decimals.number(cell, line).map_err(refused)?;
        within_bounds(number).map_err(refused)?;
        Ok(number)
    }
}

/// Whether a number may be a measurement, s, rad or command units.
///
/// # Errors
/// What is allowed.
pub(super) fn within_bounds(number: f64) -> Result<(), String> {
    if number.abs() <= LARGEST {
        return Ok(());
    }
    Err(format!(
        "in s, rad and command units a number is from -{LARGEST:e} to {LARGEST:e}"
    ))
}

fn index_of(column: &Column, heading: &[String]) -> Result<usize, String> {
    match column {
        Column::Number(number) => {
            let index = *number as usize - 1;
            (index < heading.len()).then_some(index).ok_or_else(|| {
                format!(
                    "the log has {} columns: [log] in the scenario says which column is what",
                    heading.len()
                )
            })
        }
        Column::Named(name) => {
            let mut named = (0..heading.len()).filter(|&index| heading[index] == *name);
            match (named.next(), named.next()) {
                (Some(index), None) => Ok(index),
                (Some(first), Some(second)) => Err(format!(
                    "columns {} and {} have this name: state the number of the one that is meant",
                    first + 1,
                    second + 1
                )),
                (None, _) => {
                    let known = shortened(&heading.join(", "));
                    Err(format!(
                        "the log has no such column, but {known}: [log] in the scenario says which \
                         column is what"
                    ))
                }
            }
        }
    }
}
