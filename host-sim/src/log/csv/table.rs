//! The beginning of a text as a table of all of its columns, before anything is known of them.

use std::path::Path;

use super::super::LogError;
use super::super::error::shortened;
use super::cell::Decimals;
use super::dialect::Dialect;
use super::{stamp, text};
use crate::scenario::MAX_COLUMNS;

/// The beginning of a log's table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of the separator between columns.
    pub separator: &'static str,
    /// Its columns.
    pub columns: Vec<TableColumn>,
    /// Rows that were read.
    pub rows: usize,
    /// True if the first row is a heading.
    pub has_heading: bool,
}

/// A column of a log's table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TableColumn {
    /// Its name in the heading; empty without one.
    pub name: String,
    /// Its cell in the row of units below the heading; empty without one.
    pub unit: String,
    /// Its numbers or time stamps, s; NaN for a cell that is neither.
    pub values: Vec<f64>,
    /// Cells that are numbers.
    pub numbers: usize,
    /// Cells that are time stamps.
    pub stamps: usize,
}

impl Table {
    /// Reads the beginning of a `.csv` or `.csv.gz` file.
    ///
    /// # Errors
    /// The file that cannot be read or is no table; a row that cannot be read.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        /// Most rows, and most cells of all columns.
        const MAX_ROWS: usize = 20_000;
        const MAX_CELLS: usize = 1_000_000;
        let dialect = Dialect::detect(path)?;
        let (text, allowance) = text::open(path, dialect.is_by_spaces())?;
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(dialect.separator)
            .from_reader(text);
        let mut row = csv::ByteRecord::new();
        let mut table = Self {
            separator: dialect.separator_name(),
            columns: Vec::new(),
            rows: 0,
            has_heading: false,
        };
        let mut decimals = Decimals::default();
        let mut widest = 0;
        while table.rows < MAX_ROWS.min(MAX_CELLS / table.columns.len().max(1)) {
            allowance.renew();
            let line = reader.position().line();
            let there = reader.read_byte_record(&mut row).map_err(|error| {
                let fault = format!("the row cannot be read: {error}");
                let line = error.position().map_or(line, csv::Position::line);
                LogError::at_line(path, line, None, fault)
            })?;
            if !there {
                break;
            }
            widest = widest.max(row.len());
            if table.columns.is_empty() {
                if row.len() > MAX_COLUMNS as usize {
                    let fault = format!(
                        "the log has {} columns: at most {MAX_COLUMNS} are allowed",
                        row.len()
                    );
                    return Err(LogError::at_line(path, line, None, fault));
                }
                table.columns = vec![TableColumn::default(); row.len()];
                table.has_heading = !row.iter().any(is_value);
                if table.has_heading {
                    let names = row.iter().map(as_text);
                    for (column, name) in table.columns.iter_mut().zip(names) {
                        column.name = name;
                    }
                    continue;
                }
            }
            let is_units = table.rows == 0 && table.has_heading && !row.iter().any(is_value);
            if is_units && table.columns.iter().all(|column| column.unit.is_empty()) {
                let units = row.iter().map(as_text);
                for (column, unit) in table.columns.iter_mut().zip(units) {
                    column.unit = unit;
                }
                continue;
            }
            table.add(&row, &mut decimals);
        }
        if table.columns.is_empty() {
            let fault = "the file is empty: a log has a row of column names, and a row a sample";
            return Err(LogError::in_file(path, fault.to_owned()));
        }
        if let [only] = &table.columns[..]
            && widest > 1
        {
            let first = shortened(&only.name);
            let fault = format!(
                "the first row, \"{first}\", is no heading of {widest} columns: begin the lines before the heading with #, \
                 or take them out"
            );
            return Err(LogError::at_line(path, 1, None, fault));
        }
        Ok(table)
    }

    fn add(&mut self, row: &csv::ByteRecord, decimals: &mut Decimals) {
        self.rows += 1;
        for (place, column) in self.columns.iter_mut().enumerate() {
            let cell = row.get(place).unwrap_or_default();
            let value = if let Ok(number) = decimals.number(cell, self.rows as u64) {
                column.numbers += 1;
                number
            } else if let Some(seconds) = stamp::seconds(cell) {
                column.stamps += 1;
                seconds
            } else {
                f64::NAN
            };
            column.values.push(value);
        }
    }
}

/// True for a number, a time stamp, or a number that is missing.
fn is_value(cell: &[u8]) -> bool {
    let is_float =
        std::str::from_utf8(cell.trim_ascii()).is_ok_and(|text| text.parse::<f64>().is_ok());
    is_float || super::cell::is_number(cell) || stamp::seconds(cell).is_some()
}

fn as_text(cell: &[u8]) -> String {
    String::from_utf8_lossy(cell.trim_ascii()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::Table;

    fn table(text: &str) -> Table {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("log.csv");
        std::fs::write(&file, text).expect("written");
        Table::read(&file).expect("a table")
    }

    #[test]
    fn every_column_is_read_with_name_unit_and_numbers() {
        let found = table("t;q;mode\ns;deg;\n06:00:00,5;1,5;on\n06:00:01,5;x;off\n");
        assert_eq!(
            (found.separator, found.rows, found.has_heading),
            ("semicolon", 2, true)
        );
        let [time, position, mode] = &found.columns[..] else {
            panic!("{found:?}");
        };
        assert_eq!(
            (time.name.as_str(), time.unit.as_str(), time.stamps),
            ("t", "s", 2)
        );
        assert_eq!(time.values, [21_600.5, 21_601.5]);
        assert_eq!((position.unit.as_str(), position.numbers), ("deg", 1));
        assert_eq!(position.values[..1], [1.5]);
        assert!(position.values[1].is_nan());
        assert_eq!((mode.numbers, mode.stamps), (0, 0));
    }

    #[test]
    fn a_table_may_begin_with_its_numbers() {
        let found = table("0 1.5  -2\n1 2.5   3\n");
        assert!(!found.has_heading);
        let values: Vec<_> = found
            .columns
            .iter()
            .map(|column| column.values.clone())
            .collect();
        assert_eq!(values, [vec![0.0, 1.0], vec![1.5, 2.5], vec![-2.0, 3.0]]);
    }
}
