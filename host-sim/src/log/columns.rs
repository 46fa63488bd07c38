//! A log of columns in memory.

use std::path::Path;

use super::row::{MAX_ROWS, Row, Rows, check_magnitude};
use super::{Found, LogError};
use crate::scenario::{Column, LogQuantity, LogSettings, TimeUnit};

/// The columns of a log in memory, by name, with a number per sample in the units that its settings state.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns(Vec<(String, Vec<f64>)>);

impl Columns {
    /// Columns of one length.
    ///
    /// # Errors
    /// The column that is longer or shorter than the first.
    pub fn new(columns: Vec<(String, Vec<f64>)>) -> Result<Self, String> {
        if let [(first, samples), others @ ..] = &columns[..]
            && let Some((name, other)) =
                (others.iter()).find(|(_, other)| other.len() != samples.len())
        {
            return Err(format!(
                "{name} has {} samples and {first} {}: the columns of a log are equally long",
                other.len(),
                samples.len()
            ));
        }
        Ok(Self(columns))
    }

    fn get(&self, column: &Column) -> Option<&[f64]> {
        let index = match column {
            Column::Named(name) => self.0.iter().position(|(own, _)| own == name)?,
            Column::Number(number) => (*number as usize).checked_sub(1)?,
        };
        self.0.get(index).map(|(_, samples)| &samples[..])
    }
}

/// The rows of columns, one at a time.
pub(super) struct ColumnRows<'a> {
    path: &'a Path,
    settings: &'a LogSettings,
    sample_time: f64,
    places: Vec<Place<'a>>,
    read: usize,
    left_out: u64,
}

/// A column that is read.
struct Place<'a> {
    quantity: LogQuantity,
    column: &'a Column,
    /// SI units for one of the column's.
    scale: f64,
    samples: &'a [f64],
}

impl<'a> ColumnRows<'a> {
    /// The rows of the columns that the settings state. Without a time, they are `sample_time` (s) apart.
    ///
    /// # Errors
    /// The column that is missing, or cannot be in memory.
    pub(super) fn open(
        path: &'a Path,
        settings: &'a LogSettings,
        columns: &'a Columns,
        sample_time: f64,
    ) -> Result<Self, LogError> {
        let place = |(quantity, column): (LogQuantity, &'a Column)| {
            if quantity == LogQuantity::Time && settings.units.time == TimeUnit::Stamp {
                let fault = "a column in memory has numbers, and no times by calendar and clock";
                return Err(LogError::in_column(path, column, fault.to_owned()));
            }
            let samples = columns.get(column).ok_or_else(|| {
                let names: Vec<_> = columns.0.iter().map(|(name, _)| name.as_str()).collect();
                let fault = format!("there is none; there are {}", names.join(", "));
                LogError::in_column(path, column, fault)
            })?;
            Ok(Place {
                quantity,
                column,
                scale: settings.units.scale(quantity, sample_time),
                samples,
            })
        };
        let places: Vec<_> = settings.columns().map(place).collect::<Result<_, _>>()?;
        let rows = places.first().map_or(0, |place| place.samples.len());
        if rows as u64 > MAX_ROWS {
            let fault = format!("the log has more than {MAX_ROWS} rows: divide it");
            return Err(LogError::in_file(path, fault));
        }
        Ok(Self {
            path,
            settings,
            sample_time,
            places,
            read: 0,
            left_out: 0,
        })
    }

    /// The next row; none after the last.
    fn row(&mut self) -> Option<Result<Row, LogError>> {
        let index = self.read;
        let rows = self.places.first()?.samples.len();
        if index == rows {
            return None;
        }
        self.read += 1;
        let line = self.read as u64;
        let mut row = Row::at(line, index as f64 * self.sample_time);
        let mut fault = None;
        for place in &self.places {
            let number = place.samples[index];
            let value = place.scale * number;
            if let Err(why) = check_magnitude(value) {
                fault.get_or_insert((place.column, format!("{number} is not allowed: {why}")));
            }
            row.set(place.quantity, value);
        }
        match fault {
            Some((column, fault)) if !self.settings.leaves_out(row.time) => {
                let fault = format!("{fault}; correct it, or leave its time out with log.cut");
                let column = column.to_string();
                Some(Err(LogError::at_line(
                    self.path,
                    line,
                    Some(&column),
                    fault,
                )))
            }
            _ => Some(Ok(row)),
        }
    }
}

impl Rows for ColumnRows<'_> {
    fn describe(&self, found: &mut Found) {
        found.left_out = self.left_out;
    }
}

impl Iterator for ColumnRows<'_> {
    type Item = Result<Row, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let row = self.row()?;
            let is_left_out = |row: &Row| self.settings.leaves_out(row.time);
            if !row.as_ref().is_ok_and(is_left_out) {
                return Some(row);
            }
            self.left_out += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Columns;
    use crate::log::Log;
    use crate::scenario::{Column, LogSettings, PositionUnit};

    const SAMPLE_TIME: f64 = 1e-3;

    fn settings() -> LogSettings {
        let mut settings = LogSettings::with_position(Column::named("position"));
        settings.command = Some(Column::named("command"));
        settings.sample_time = Some(SAMPLE_TIME);
        settings
    }

    fn columns(samples: usize) -> Vec<(String, Vec<f64>)> {
        let angles = || (0..samples).map(|sample| 0.01 * sample as f64);
        let of = |name: &str, column: Vec<f64>| (name.to_owned(), column);
        vec![
            of("command", angles().map(f64::cos).collect()),
            of("position", angles().map(f64::sin).collect()),
        ]
    }

    fn refusal(columns: Vec<(String, Vec<f64>)>, settings: &LogSettings) -> String {
        let columns = Columns::new(columns).expect("one length");
        let log = Log::of_columns("log", columns, settings, settings.sample_time);
        log.expect_err("it is refused").to_string()
    }

    #[test]
    fn rows_are_the_columns_in_si() {
        let mut settings = settings();
        settings.units.position = PositionUnit::Degree;
        settings.cut = vec![[0.0, 0.0095]];
        let columns = Columns::new(columns(50)).expect("one length");
        let log = Log::of_columns("log", columns.clone(), &settings, Some(SAMPLE_TIME));
        let log = log.expect("it is sound");
        assert_eq!((log.samples, log.found.left_out), (40, 10));
        for (row, sample) in log.rows().expect("rows").zip(10..) {
            let row = row.expect("a row");
            let angle = 0.01 * f64::from(sample);
            assert!((row.time - SAMPLE_TIME * f64::from(sample)).abs() < 1e-12);
            assert!((row.position - angle.sin().to_radians()).abs() < 1e-15);
            assert_eq!(row.command, Some(angle.cos()));
        }
    }

    #[test]
    fn a_wrong_column_is_named_with_its_row() {
        let mut unequal = columns(50);
        unequal[0].1.pop();
        let refused = Columns::new(unequal).expect_err("two lengths");
        assert!(
            refused.starts_with("position has 50 samples and command 49"),
            "{refused}"
        );

        let mut spoilt = columns(50);
        spoilt[0].1[17] = f64::INFINITY;
        let refused = refusal(spoilt, &settings());
        assert!(
            refused.starts_with("log:18: column command: inf is not allowed"),
            "{refused}"
        );

        let mut other = settings();
        other.command = Some(Column::named("torque"));
        let refused = refusal(columns(50), &other);
        assert!(
            refused.contains("column torque: there is none; there are command, position"),
            "{refused}"
        );
        assert!(refusal(columns(5), &settings()).contains("5 samples"));
    }
}
