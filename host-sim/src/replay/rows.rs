//! The rows of a log that is a text, one at a time: columns, numbers, and bounds on all that is read.

use std::path::Path;

use super::cell::Decimals;
use super::columns::{Columns, Place};
use super::dialect::Dialect;
use super::error::LogError;
use super::text::{self, Allowance, Text};
use crate::scenario::{Column, LogSettings, MOST_COLUMNS};

/// The most rows of a log.
pub(super) const MOST_ROWS: u64 = 1_000_000_000;

/// One sample of a log, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// The line of the file, from 1, the heading among them, or the number of the message; of a bridged
    /// sample, that after the gap.
    pub line: u64,
    /// Time, s.
    pub time: f64,
    /// Reference position, where the log has one.
    pub reference: Option<f64>,
    /// Measured position.
    pub position: f64,
    /// The command that acted from here to the next sample, where the log has one.
    pub command: Option<f64>,
    /// Known signal behind the controller; zero where the log has none.
    pub injection: f64,
    /// Whether a straight line stands in for what was not recorded.
    pub bridged: bool,
    /// Whether nothing is known of what came directly before: it is the first, or the first behind a
    /// range that was left out.
    pub begins: bool,
}

/// Reads a file row by row, of which there is never more than one in memory. Rows in ranges of time that
/// are left out are passed over.
pub(super) struct TextRows<'a> {
    path: &'a Path,
    settings: &'a LogSettings,
    sample_time: f64,
    columns: Columns,
    dialect: Dialect,
    /// Fields that a row must have.
    width: usize,
    reader: csv::Reader<Text>,
    row: csv::ByteRecord,
    /// The line of `row`.
    line: u64,
    /// Whether `row` is the first sample, read while a heading was looked for.
    holds: bool,
    allowance: Allowance,
    decimals: Decimals,
    read: u64,
    /// Rows that were left out.
    pub(super) left_out: u64,
    /// What the row of units says, if there is one.
    pub(super) units_row: Option<String>,
}

impl<'a> TextRows<'a> {
    /// Opens a `.csv` or `.csv.gz` file and finds its columns. Rows without a column of time, and those
    /// of a counter, are `sample_time` (s) apart.
    ///
    /// # Errors
    /// The file, or the column that it has not got.
    pub(super) fn open(
        path: &'a Path,
        settings: &'a LogSettings,
        dialect: Dialect,
        sample_time: f64,
    ) -> Result<Self, LogError> {
        /// Bytes that are read at once.
        const AT_ONCE: usize = 1 << 16;
        let (text, allowance) = text::open(path)?;
        let mut reader = csv::ReaderBuilder::new()
            .buffer_capacity(AT_ONCE)
            .has_headers(false)
            .flexible(true)
            .delimiter(dialect.separator)
            .from_reader(text);
        let mut row = csv::ByteRecord::new();
        reader.read_byte_record(&mut row).map_err(|error| {
            let fault = format!("no heading can be read: {error}");
            LogError::of_line(path, 1, None, fault)
        })?;
        let line = reader.position().line().saturating_sub(1).max(1);
        let width = row.len();
        if width == 0 {
            let fault = "the file is empty: a log has a row of column names, and a row a sample";
            return Err(LogError::of_file(path, fault.to_owned()));
        }
        if width > MOST_COLUMNS as usize {
            let fault = format!("the log has {width} columns: at most {MOST_COLUMNS} are allowed");
            return Err(LogError::of_line(path, line, None, fault));
        }
        let columns = Columns::find(path, line, &row, settings, sample_time)?;
        let mut rows = Self {
            path,
            settings,
            sample_time,
            // Columns that go by number need no heading.
            holds: !has_names(settings) && !columns.are_words(&row),
            columns,
            dialect,
            width,
            reader,
            row,
            line,
            allowance,
            decimals: Decimals::default(),
            read: 0,
            left_out: 0,
            units_row: None,
        };
        if !rows.holds && rows.read_row()? {
            if rows.columns.are_words(&rows.row) {
                rows.units_row = Some(rows.columns.words(&rows.row));
            } else {
                rows.holds = true;
            }
        }
        Ok(rows)
    }

    /// Whether the numbers were found to have decimal commas.
    pub(super) fn has_decimal_commas(&self) -> bool {
        self.decimals.are_commas()
    }

    /// Reads the next row; false after the last.
    fn advance(&mut self) -> Result<bool, LogError> {
        if !std::mem::take(&mut self.holds) && !self.read_row()? {
            return Ok(false);
        }
        self.read += 1;
        if self.read > MOST_ROWS {
            let fault = format!("the log has more than {MOST_ROWS} rows: divide it");
            return Err(self.fault(None, fault));
        }
        Ok(true)
    }

    fn read_row(&mut self) -> Result<bool, LogError> {
        self.allowance.renew();
        let line = self.reader.position().line();
        let there = self
            .reader
            .read_byte_record(&mut self.row)
            .map_err(|error| {
                let fault = format!("the row cannot be read: {error}");
                let line = error.position().map_or(line, csv::Position::line);
                LogError::of_line(self.path, line, None, fault)
            })?;
        // Every line ends with a line feed, so the reader stands on the next one.
        self.line = self.reader.position().line().saturating_sub(1);
        Ok(there)
    }

    /// A row may have an empty field behind its last.
    fn check_width(&self) -> Result<(), LogError> {
        let (width, found) = (self.width, self.row.len());
        let ends_empty = || {
            self.row
                .get(width)
                .is_some_and(|last| last.trim_ascii().is_empty())
        };
        if found == width || found == width + 1 && ends_empty() {
            return Ok(());
        }
        let mut fault = format!(
            "the row cannot be read: it has {found} fields where the first row has {width}"
        );
        if let Some(other) = self.dialect.others(self.row.as_slice()) {
            let own = self.dialect.separator_name();
            fault += &format!(
                "; the first row is separated by a {own}, and this row has a {other}: separate all \
                 alike"
            );
        } else if self.dialect.separator == b',' && found > width {
            fault += "; numbers with decimal commas need semicolons, tabs or quotation marks";
        }
        Err(self.fault(None, fault))
    }

    fn fault(&self, column: Option<&str>, fault: String) -> LogError {
        LogError::of_line(self.path, self.line, column, fault)
    }

    /// The sample of the row; nothing in a range that is left out, whatever else the row has.
    fn record(&mut self) -> Result<Option<Record>, LogError> {
        let mut decimals = self.decimals;
        let (row, line) = (&self.row, self.line);
        let mut number = |place: &Place| {
            place
                .number(row, line, &mut decimals)
                .map_err(|fault| LogError::of_line(self.path, line, Some(&place.name), fault))
        };
        let columns = &self.columns;
        let time = match &columns.time {
            Some(time) => number(time),
            None => Ok((self.read - 1) as f64 * self.sample_time),
        };
        let is_out = |time: &f64| {
            let mut ranges = self.settings.cut.iter();
            ranges.any(|[from, to]| (from..=to).contains(&time))
        };
        if time.as_ref().is_ok_and(is_out) {
            self.left_out += 1;
            return Ok(None);
        }
        self.check_width()?;
        let time = time?;
        let record = Record {
            line,
            time,
            reference: columns.reference.as_ref().map(&mut number).transpose()?,
            position: number(&columns.position)?,
            command: columns.command.as_ref().map(&mut number).transpose()?,
            injection: columns.injection.as_ref().map_or(Ok(0.0), &mut number)?,
            bridged: false,
            begins: false,
        };
        self.decimals = decimals;
        Ok(Some(record))
    }
}

impl Iterator for TextRows<'_> {
    type Item = Result<Record, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.advance() {
                Ok(true) => match self.record().transpose() {
                    Some(record) => return Some(record),
                    None => continue,
                },
                Ok(false) => return None,
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

/// Whether some column goes by its name.
fn has_names(settings: &LogSettings) -> bool {
    let optional = [
        &settings.time,
        &settings.reference,
        &settings.command,
        &settings.injection,
    ];
    let mut stated = optional.into_iter().flatten().chain([&settings.position]);
    stated.any(|column| matches!(column, Column::Named(_)))
}
