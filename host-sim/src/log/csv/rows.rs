//! The rows of a text, one at a time, with bounds on all that is read.

use std::path::Path;

use super::super::row::{MAX_ROWS, Row, Rows};
use super::super::{Found, LogError};
use super::cell::Decimals;
use super::columns::{Columns, Place};
use super::dialect::Dialect;
use super::text::{self, Allowance, Text};
use crate::scenario::{Column, LogQuantity, LogSettings, MAX_COLUMNS};

/// Reads a text row by row, with one row in memory.
pub(in super::super) struct TextRows<'a> {
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
    /// True while `row` holds the first sample, read in search of a heading.
    holds_sample: bool,
    allowance: Allowance,
    decimals: Decimals,
    read: u64,
    /// Rows that were left out.
    left_out: u64,
    /// The words of the row of units, if there is one.
    units_row: Option<String>,
}

impl<'a> TextRows<'a> {
    /// Opens a `.csv` or `.csv.gz` file and finds its columns. Rows without a column of time, and those
    /// of a counter, are `sample_time` (s) apart.
    ///
    /// # Errors
    /// The file, or the column that it has not got.
    pub(in super::super) fn open(
        path: &'a Path,
        settings: &'a LogSettings,
        dialect: Dialect,
        sample_time: f64,
    ) -> Result<Self, LogError> {
        /// Bytes that are read at once.
        const BUFFER: usize = 1 << 16;
        let (text, allowance) = text::open(path, dialect.is_by_spaces())?;
        let mut reader = csv::ReaderBuilder::new()
            .buffer_capacity(BUFFER)
            .has_headers(false)
            .flexible(true)
            .delimiter(dialect.separator)
            .from_reader(text);
        let mut row = csv::ByteRecord::new();
        reader.read_byte_record(&mut row).map_err(|error| {
            let fault = format!("no heading can be read: {error}");
            LogError::at_line(path, 1, None, fault)
        })?;
        let line = reader.position().line().saturating_sub(1).max(1);
        let width = row.len();
        if width == 0 {
            let fault = "the file is empty: a log has a row of column names, and a row a sample";
            return Err(LogError::in_file(path, fault.to_owned()));
        }
        if width > MAX_COLUMNS as usize {
            let fault = format!("the log has {width} columns: at most {MAX_COLUMNS} are allowed");
            return Err(LogError::at_line(path, line, None, fault));
        }
        let columns = Columns::find(path, line, &row, settings, sample_time)?;
        let by_name = (settings.columns()).any(|(_, column)| matches!(column, Column::Named(_)));
        let mut rows = Self {
            path,
            settings,
            sample_time,
            // Columns that go by number need no heading.
            holds_sample: !by_name && !columns.are_words(&row),
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
        if !rows.holds_sample && rows.read_row()? {
            if rows.columns.are_words(&rows.row) {
                rows.units_row = Some(rows.columns.words(&rows.row));
            } else {
                rows.holds_sample = true;
            }
        }
        Ok(rows)
    }

    /// Reads the next row; false after the last.
    fn advance(&mut self) -> Result<bool, LogError> {
        if !std::mem::take(&mut self.holds_sample) && !self.read_row()? {
            return Ok(false);
        }
        self.read += 1;
        if self.read > MAX_ROWS {
            let fault = format!("the log has more than {MAX_ROWS} rows: divide it");
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
                LogError::at_line(self.path, line, None, fault)
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
        LogError::at_line(self.path, self.line, column, fault)
    }

    /// The sample of the row; none in a range that is left out, whatever else the row has.
    fn sample(&mut self) -> Result<Option<Row>, LogError> {
        let mut decimals = self.decimals;
        let (row, line) = (&self.row, self.line);
        let mut number = |place: &Place| {
            place
                .number(row, line, &mut decimals)
                .map_err(|fault| LogError::at_line(self.path, line, Some(&place.name), fault))
        };
        let (time, others) = match &self.columns.0[..] {
            [time, others @ ..] if time.quantity == LogQuantity::Time => (number(time), others),
            all => (Ok((self.read - 1) as f64 * self.sample_time), all),
        };
        if time
            .as_ref()
            .is_ok_and(|time| self.settings.leaves_out(*time))
        {
            self.left_out += 1;
            return Ok(None);
        }
        self.check_width()?;
        let mut sample = Row::at(line, time?);
        for place in others {
            sample.set(place.quantity, number(place)?);
        }
        self.decimals = decimals;
        Ok(Some(sample))
    }
}

impl Rows for TextRows<'_> {
    fn describe(&self, found: &mut Found) {
        found.left_out = self.left_out;
        found.separator = Some(self.dialect.separator_name());
        found.decimal_commas = self.decimals.are_commas();
        found.units_row.clone_from(&self.units_row);
    }
}

impl Iterator for TextRows<'_> {
    type Item = Result<Row, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.advance() {
                Ok(true) => match self.sample().transpose() {
                    Some(sample) => return Some(sample),
                    None => continue,
                },
                Ok(false) => return None,
                Err(error) => return Some(Err(error)),
            }
        }
    }
}
