//! The columns of a text, and their numbers in SI.

use std::path::Path;

use super::super::LogError;
use super::super::error::shortened;
use super::super::row::check_magnitude;
use super::cell::{Decimals, is_words};
use super::stamp;
use crate::scenario::{Column, LogQuantity, LogSettings, TimeUnit};

/// A column that is read.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) quantity: LogQuantity,
    index: usize,
    /// The column's name in messages.
    pub(super) name: String,
    /// SI units for one of the column's.
    scale: f64,
    /// True for a time by calendar and clock.
    is_stamp: bool,
}

/// The columns of a log that are read, time first where there is one.
#[derive(Debug, Clone)]
pub(super) struct Columns(pub(super) Vec<Place>);

impl Columns {
    /// Finds them in the first row, which is the heading on this line; a sample lasts `sample_time`, s.
    ///
    /// # Errors
    /// The column that is missing, or there twice.
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
        let place = |(quantity, column): (LogQuantity, &Column)| {
            let name = column.to_string();
            let index = index_of(column, &heading)
                .map_err(|fault| LogError::at_line(path, line, Some(&name), fault))?;
            let scale = settings.units.scale(quantity, sample_time);
            Ok(Place {
                quantity,
                index,
                name,
                scale,
                is_stamp: quantity == LogQuantity::Time && settings.units.time == TimeUnit::Stamp,
            })
        };
        settings
            .columns()
            .map(place)
            .collect::<Result<_, _>>()
            .map(Self)
    }

    /// True for a row with words in all of these columns, and at least one not empty: a heading, or the
    /// units.
    pub(super) fn are_words(&self, row: &csv::ByteRecord) -> bool {
        let cells = || self.0.iter().map(|place| place.cell(row));
        cells().all(is_words) && cells().any(|cell| !cell.is_empty())
    }

    /// The words of a row in these columns.
    pub(super) fn words(&self, row: &csv::ByteRecord) -> String {
        let cells = self
            .0
            .iter()
            .map(|place| String::from_utf8_lossy(place.cell(row)));
        shortened(&cells.collect::<Vec<_>>().join(", "))
    }
}

impl Place {
    fn cell<'r>(&self, row: &'r csv::ByteRecord) -> &'r [u8] {
        row.get(self.index).unwrap_or_default().trim_ascii()
    }

    /// The number of a row in this column, SI.
    ///
    /// # Errors
    /// Why it is not allowed.
    pub(super) fn number(
        &self,
        row: &csv::ByteRecord,
        line: u64,
        decimals: &mut Decimals,
    ) -> Result<f64, String> {
        let cell = self.cell(row);
        let refused = |why: String| {
            let cell = shortened(&String::from_utf8_lossy(cell));
            format!(
                "\"{cell}\" is not allowed: {why}; correct it, or leave its time out with log.cut"
            )
        };
        let number = match self.is_stamp {
            true => stamp::seconds(cell)
                .ok_or_else(|| "it must be a time such as 2026-11-22T06:25:00.125".to_owned()),
            false => decimals.number(cell, line),
        };
        let number = self.scale * number.map_err(refused)?;
        check_magnitude(number).map_err(refused)?;
        Ok(number)
    }
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
