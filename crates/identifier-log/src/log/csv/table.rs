//! The text of a log as columns in memory, before anything is known of them.

use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::super::LogError;
use super::super::error::shortened;
#[cfg(feature = "files")]
use super::super::source;
use super::cell::{Decimals, is_missing, is_value, list, name_and_value};
use super::dialect::Dialect;
use super::{stamp, text};
use crate::scenario::{Column, MAX_COLUMNS};

/// A log's columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The file, or its name in messages.
    pub path: PathBuf,
    /// The SHA-256 of what was read, in hexadecimal digits; none of columns in memory.
    pub sha256: Option<String>,
    /// Name of the separator between columns; none of columns in memory.
    pub separator: Option<&'static str>,
    /// Its columns, all as long.
    pub columns: Vec<TableColumn>,
    /// The line of each row, from 1.
    pub lines: Vec<u32>,
    /// True if a row of names is above the numbers.
    pub has_heading: bool,
    /// True for numbers with decimal commas.
    pub decimal_commas: bool,
    /// How the text was read, where that is not plain.
    pub notes: Vec<String>,
    /// The rows at which a file begins, besides the first.
    pub begins: Vec<usize>,
    /// Lines of numbers that were left out: few, and of another width than all others.
    pub damaged: u64,
}

/// A column of a log's table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TableColumn {
    /// Its name in the heading; empty without one.
    pub name: String,
    /// Its cell in the row of units below the heading; empty without one.
    pub unit: String,
    /// Its numbers or time stamps, s; NaN where a row has none.
    pub values: Vec<f64>,
    /// Cells that are time stamps.
    pub stamps: usize,
    /// Cells that are something else, by row, the first ones of many, and why each is no number.
    pub(in super::super) others: Vec<(usize, String)>,
}

impl Table {
    /// The most rows: more do not fit into the memory of a usual machine.
    const MAX_ROWS: usize = 20_000_000;

    /// Reads text, plain or packed with gzip, from a file, from a pipe or, for the name `-`, from standard input.
    ///
    /// # Errors
    /// The file that cannot be read or is no table; the row that cannot be read.
    #[cfg(feature = "files")]
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let (bytes, fingerprint) = source::open(path)?;
        let [dash, standard_input] = source::STANDARD_INPUT.map(Path::new);
        let name = if path == dash { standard_input } else { path };
        let table = Self::of_text(name, bytes)?;
        Ok(Self {
            sha256: Some(fingerprint.digits()),
            ..table
        })
    }

    /// Reads a text, which has a `name` in messages.
    ///
    /// # Errors
    /// As of a file.
    pub fn of_text(name: &Path, mut bytes: impl Read + 'static) -> Result<Self, LogError> {
        let mut beginning = Vec::new();
        (&mut bytes)
            .take(Dialect::EXAMINED)
            .read_to_end(&mut beginning)
            .map_err(|error| LogError::in_file(name, format!("the log cannot be read: {error}")))?;
        let dialect = Dialect::detect(name, &beginning)?;
        let whole = Box::new(std::io::Cursor::new(beginning).chain(bytes));
        Reader::new(name, dialect).read(whole)
    }

    /// Columns in memory.
    ///
    /// # Errors
    /// The column that is longer or shorter than the first.
    pub fn of_columns(name: &str, columns: Vec<(String, Vec<f64>)>) -> Result<Self, String> {
        if let [(first, samples), others @ ..] = &columns[..]
            && let Some((name, other)) =
                (others.iter()).find(|(_, other)| other.len() != samples.len())
        {
            return Err(format!(
                "{name} has {} samples but {first} has {}: all columns of a log must have the same length",
                other.len(),
                samples.len()
            ));
        }
        let rows = columns.first().map_or(0, |(_, samples)| samples.len());
        let column = |(name, values)| TableColumn {
            name,
            values,
            ..TableColumn::default()
        };
        Ok(Self {
            path: PathBuf::from(name),
            columns: columns.into_iter().map(column).collect(),
            lines: (1..=u32::try_from(rows).unwrap_or(u32::MAX)).collect(),
            has_heading: true,
            ..Self::default()
        })
    }

    /// The rows of several logs with the same columns, one after the other.
    ///
    /// # Errors
    /// The log that has other columns.
    pub fn joined(tables: &[Self]) -> Result<Cow<'_, Self>, LogError> {
        let (all, further) = match tables {
            [] => return Ok(Cow::default()),
            [one] => return Ok(Cow::Borrowed(one)),
            [first, further @ ..] => (first, further),
        };
        let mut all = all.clone();
        for table in further {
            let names = |table: &Self| -> Vec<String> {
                table
                    .columns
                    .iter()
                    .map(|column| column.name.clone())
                    .collect()
            };
            if names(table) != names(&all) {
                let fault = format!(
                    "its columns differ from those of {}: logs that are identified together must have the same columns",
                    all.path.display()
                );
                return Err(LogError::in_file(&table.path, fault));
            }
            all.begins.push(all.rows());
            all.lines.extend(&table.lines);
            for (column, more) in all.columns.iter_mut().zip(&table.columns) {
                column.values.extend(&more.values);
                column.stamps += more.stamps;
            }
        }
        Ok(Cow::Owned(all))
    }

    /// Tables of one column each as one: files of a signal each. One without a heading has the name of its file.
    ///
    /// # Errors
    /// The file that is not as long as the first.
    pub fn of_signals(files: Vec<Self>) -> Result<Vec<Self>, LogError> {
        if files.len() < 2 || files.iter().any(|file| file.columns.len() != 1) {
            return Ok(files);
        }
        let mut all = files[0].clone();
        let columns = files.into_iter().map(|mut file| {
            if file.rows() != all.rows() {
                let fault = format!(
                    "it has {} rows, but {} has {}: files of a signal each must be of one length",
                    file.rows(),
                    all.path.display(),
                    all.rows()
                );
                return Err(LogError::in_file(&file.path, fault));
            }
            let mut column = file.columns.swap_remove(0);
            if column.name.is_empty() {
                let name = file.path.file_name().unwrap_or_default().to_string_lossy();
                column.name = name.split('.').next().unwrap_or_default().to_owned();
            }
            Ok(column)
        });
        all.columns = columns.collect::<Result<_, _>>()?;
        all.has_heading = true;
        Ok(vec![all])
    }

    /// Rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The place of a column.
    ///
    /// # Errors
    /// Why there is none.
    pub fn place(&self, column: &Column) -> Result<usize, LogError> {
        let names = || self.columns.iter().map(|column| column.name.as_str());
        let fault = match column {
            Column::Number(number) => {
                let place = (*number as usize).wrapping_sub(1);
                if place < self.columns.len() {
                    return Ok(place);
                }
                format!(
                    "the log has {} columns: state the column's number in [log] of the scenario",
                    self.columns.len()
                )
            }
            Column::Named(name) => {
                let mut named =
                    (0..self.columns.len()).filter(|&at| self.columns[at].name == *name);
                match (named.next(), named.next()) {
                    (Some(place), None) => return Ok(place),
                    (Some(first), Some(second)) => format!(
                        "columns {} and {} have this name: state the column's number instead",
                        first + 1,
                        second + 1
                    ),
                    (None, _) => format!(
                        "the log has no such column, but {}: state the column in [log] of the scenario",
                        shortened(&names().collect::<Vec<_>>().join(", "))
                    ),
                }
            }
        };
        Err(LogError::in_column(&self.path, column, fault))
    }

    /// Names the columns of a table in which each signal has a column of times before it, and keeps one of the times.
    ///
    /// # Errors
    /// The signal with other times.
    fn name_pairs(&mut self) -> Result<(), LogError> {
        let is_pair = |pair: &[TableColumn]| {
            let [x, y] = pair else { return false };
            !x.name.is_empty() && y.name.is_empty() && !x.unit.is_empty() && !y.unit.is_empty()
        };
        if self.columns.len() < 4 || !self.columns.chunks(2).all(is_pair) {
            return Ok(());
        }
        let times = self.columns[0].values.clone();
        for pair in self.columns.chunks_mut(2) {
            let differs = |(own, of): (&f64, &f64)| own.is_finite() && own.total_cmp(of).is_ne();
            if let Some(row) = pair[0].values.iter().zip(&times).position(differs) {
                let column = Column::Named(pair[0].name.clone());
                let line = self.lines[row];
                let fault = format!(
                    "its times are not those of the first column (line {line}): export all signals with the same times"
                );
                return Err(LogError::in_column(&self.path, &column, fault));
            }
            pair[1].name = std::mem::take(&mut pair[0].name);
        }
        // A channel that ends earlier ends the log.
        let ends = self.columns.iter().filter_map(|one| {
            let last = one.values.iter().rposition(|value| value.is_finite());
            last.map(|last| last + 1)
        });
        let rows = ends.min().unwrap_or(0);
        self.lines.truncate(rows);
        let mut place = 0;
        for column in &mut self.columns {
            column.values.truncate(rows);
        }
        self.columns.retain(|_| {
            place += 1;
            place == 1 || place % 2 == 0
        });
        self.columns[0].name = "time".to_owned();
        Ok(())
    }
}

/// A table that is being read.
struct Reader<'a> {
    name: &'a Path,
    dialect: Dialect,
    decimals: Decimals,
    table: Table,
    /// The rows of words above the numbers, with their lines.
    heading: Vec<(u64, csv::ByteRecord)>,
    /// The fault of a heading without a name for the first column, unless that names the rows.
    unnamed: Option<LogError>,
    /// The numbers in each cell of a row; 0 of a cell that is no list.
    lists: Vec<usize>,
    /// Lines that may be a signal each: the first few, of many cells without names.
    signals: Option<Vec<(u64, csv::ByteRecord)>>,
    /// The first line of another width, what is wrong with it, and the rows that are narrower than the others.
    damaged: Option<LogError>,
    narrow: Vec<usize>,
}

impl<'a> Reader<'a> {
    fn new(name: &'a Path, dialect: Dialect) -> Self {
        let table = Table {
            path: name.to_owned(),
            separator: Some(dialect.separator_name()),
            ..Table::default()
        };
        Self {
            name,
            dialect,
            decimals: Decimals::default(),
            table,
            heading: Vec::new(),
            unnamed: None,
            lists: Vec::new(),
            signals: None,
            damaged: None,
            narrow: Vec::new(),
        }
    }

    fn read(mut self, bytes: Box<dyn Read>) -> Result<Table, LogError> {
        const BUFFER: usize = 1 << 16;
        let (text, allowance) = text::from_bytes(bytes, self.dialect);
        let mut reader = csv::ReaderBuilder::new()
            .buffer_capacity(BUFFER)
            .has_headers(false)
            .flexible(true)
            .delimiter(self.dialect.separator)
            .from_reader(text);
        let mut row = csv::ByteRecord::new();
        loop {
            allowance.renew();
            let line = reader.position().line();
            let there = reader.read_byte_record(&mut row).map_err(|error| {
                let line = error.position().map_or(line, csv::Position::line);
                self.fault(line, format!("the row cannot be read: {error}"))
            })?;
            if !there {
                break;
            }
            // Every line ends with a line feed, so the reader stands on the next one.
            let line = reader.position().line().saturating_sub(1);
            self.take(&row, line)?;
        }
        match self.signals.take() {
            Some(signals) => self.turned(&signals),
            None => self.finish(),
        }
    }

    /// Takes the next row of text.
    fn take(&mut self, row: &csv::ByteRecord, line: u64) -> Result<(), LogError> {
        /// The most lines of a signal each.
        const MAX_SIGNALS: usize = 20;
        let is_above = self.table.columns.is_empty();
        if !row.iter().any(is_value) {
            // Of several rows of words above the numbers the first as wide has the names, the next the units.
            if is_above && line >= self.dialect.heading {
                self.heading.push((line, row.clone()));
            }
            return Ok(());
        }
        if is_above {
            self.begin(row, line)?;
        }
        match self.signals.take() {
            Some(mut signals) if signals.len() < MAX_SIGNALS => {
                signals.push((line, row.clone()));
                self.signals = Some(signals);
                return Ok(());
            }
            Some(signals) => {
                self.check_width(signals[0].0)?;
                for (line, row) in &signals {
                    self.add(row, *line)?;
                }
            }
            None => {}
        }
        self.add(row, line)
    }

    /// The table of lines that are a signal each.
    fn turned(&self, signals: &[(u64, csv::ByteRecord)]) -> Result<Table, LogError> {
        let samples = bare(&signals[0].1);
        if let Some((line, row)) = signals.iter().find(|(_, row)| bare(row) != samples) {
            let fault = format!(
                "it has {} cells where the first line has {samples}: lines of a signal each must be of one length",
                bare(row)
            );
            return Err(self.fault(*line, fault));
        }
        let dialect = Dialect {
            heading: 1,
            ..self.dialect
        };
        let mut turned = Self::new(self.name, dialect);
        turned.table.notes = vec!["a signal a line".to_owned()];
        for (at, line) in (0..samples).zip(1..) {
            turned.take(&signals.iter().map(|(_, row)| &row[at]).collect(), line)?;
        }
        turned.finish()
    }

    fn finish(mut self) -> Result<Table, LogError> {
        self.leave_out_damaged()?;
        if let Some(fault) = self.unnamed {
            if !self.table.columns[0].names_rows() {
                return Err(fault);
            }
            let note = "the first column has no name and names the rows";
            self.table.notes.push(note.to_owned());
        }
        self.table.name_pairs()?;
        if self.table.lines.is_empty() {
            let fault = match self.heading.len() {
                0 => "the file is empty: a log has a row of column names and one row per sample",
                1 => "the log has a heading and no samples: record the motion of the servo",
                _ => {
                    "no row has numbers in two or more columns: a log has one row per sample, with position and command"
                }
            };
            return Err(LogError::in_file(self.name, fault.to_owned()));
        }
        self.table.decimal_commas = self.decimals.are_commas();
        Ok(self.table)
    }

    fn fault(&self, line: u64, fault: String) -> LogError {
        LogError::at_line(self.name, line, None, fault)
    }

    /// # Errors
    /// More columns than are allowed.
    fn check_width(&self, line: u64) -> Result<(), LogError> {
        let width = self.table.columns.len();
        if width > MAX_COLUMNS as usize {
            let fault = format!("the log has {width} columns: at most {MAX_COLUMNS} are allowed");
            return Err(self.fault(line, fault));
        }
        Ok(())
    }

    /// Takes the names of the columns from the text above the first row of numbers, or from its own cells.
    fn begin(&mut self, row: &csv::ByteRecord, line: u64) -> Result<(), LogError> {
        /// The fewest cells of a line that may be a signal.
        const MIN_SAMPLES: usize = 100;
        let heading = std::mem::take(&mut self.heading);
        let is_as_wide = |(_, names): &&(u64, csv::ByteRecord)| {
            names.len() == row.len() || [names.len(), bare(names)].contains(&bare(row))
        };
        let mut words = heading.iter().rev().filter(is_as_wide);
        let (units, mut names) = match (words.next(), words.next()) {
            (Some(units), Some(names)) => (Some(units), Some(names)),
            (only, _) => (None, only),
        };
        // A name less: R and pandas have none for the names of the rows.
        let mut unnamed = 0;
        if let (None, Some(last)) = (names, heading.last())
            && bare(&last.1).abs_diff(bare(row)) == 1
        {
            let fault = format!(
                "this heading has {} names, but line {line} has {} cells: name each column, or delete this line and state \
                 the columns by number",
                bare(&last.1),
                bare(row)
            );
            let fault = self.fault(last.0, fault);
            if bare(&last.1) > bare(row) {
                return Err(fault);
            }
            (names, unnamed, self.unnamed) = (Some(last), 1, Some(fault));
        }
        let text = |cell: &[u8]| decoded(cell.trim_ascii());
        let texts = |words: &(u64, csv::ByteRecord)| words.1.iter().map(text).collect();
        let mut name: Vec<String> = vec![String::new(); unnamed];
        let mut width = row.len();
        self.table.has_heading = true;
        if let Some(names) = names {
            name.extend::<Vec<_>>(texts(names));
            width = width.min(name.len());
        } else if row.iter().all(|cell| name_and_value(cell).is_some()) {
            name.extend(
                row.iter()
                    .filter_map(|cell| Some(text(name_and_value(cell)?.0))),
            );
        } else {
            self.table.has_heading = false;
        }
        let unit: Vec<String> = units.map_or(Vec::new(), texts);
        if units.is_some() {
            let units = shortened(&unit.join(", "));
            let note = format!("the row below the heading holds units ({units})");
            self.table.notes.push(note);
        }
        for (at, cell) in row.iter().enumerate().take(width) {
            let [name, unit] = [&name, &unit].map(|of| of.get(at).cloned().unwrap_or_default());
            let numbers = list(cell).map_or(0, |list| list.len());
            self.lists.push(numbers);
            self.table
                .columns
                .extend((0..numbers.max(1)).map(|element| TableColumn {
                    name: match numbers {
                        0 => name.clone(),
                        _ => of_element(&name, element),
                    },
                    unit: unit.clone(),
                    ..TableColumn::default()
                }));
        }
        if width >= MIN_SAMPLES && !self.table.has_heading {
            self.signals = Some(Vec::new());
            return Ok(());
        }
        self.check_width(line)
    }

    /// A row with a cell for each number of its lists.
    ///
    /// # Errors
    /// A list of another length than in the first row.
    fn unlisted<'r>(
        &self,
        row: &'r csv::ByteRecord,
        line: u64,
    ) -> Result<Cow<'r, csv::ByteRecord>, LogError> {
        if self.lists.iter().all(|numbers| *numbers == 0) {
            return Ok(Cow::Borrowed(row));
        }
        let mut cells = csv::ByteRecord::new();
        let lengths = self.lists.iter().copied().chain(std::iter::repeat(0));
        for (cell, length) in row.iter().zip(lengths) {
            let found = list(cell).filter(|_| length > 0).unwrap_or_default();
            match length {
                0 => cells.push_field(cell),
                _ if found.len() == length => cells.extend(found),
                _ if is_missing(cell) => cells.extend(std::iter::repeat_n("", length)),
                _ => {
                    let fault = format!(
                        "\"{}\" is no list of {length} numbers as in the first row: write lists of one length",
                        shortened(&decoded(cell))
                    );
                    return Err(self.fault(line, fault));
                }
            }
        }
        Ok(Cow::Owned(cells))
    }

    fn add(&mut self, row: &csv::ByteRecord, line: u64) -> Result<(), LogError> {
        /// Cells of a column that are no numbers which are kept.
        const MAX_OTHERS: usize = 1024;
        let row = self.unlisted(row, line)?;
        let (width, found) = (self.table.columns.len(), row.len());
        let ends_empty = row
            .get(width)
            .is_some_and(|last| last.trim_ascii().is_empty());
        if found > width && !(found == width + 1 && ends_empty) {
            self.table.damaged += 1;
            if self.damaged.is_none() {
                self.damaged = Some(self.fault(line, self.too_wide(&row)));
            }
            return Ok(());
        }
        let place = self.table.lines.len();
        if found + 1 < width {
            self.narrow.push(place);
        }
        if place == Table::MAX_ROWS {
            let fault = format!("the log has more than {place} rows: split it");
            return Err(self.fault(line, fault));
        }
        self.table
            .lines
            .push(u32::try_from(line).unwrap_or(u32::MAX));
        for (at, column) in self.table.columns.iter_mut().enumerate() {
            let cell = row.get(at).unwrap_or_default();
            let value = if is_missing(cell) {
                f64::NAN
            } else {
                match self.decimals.number(cell, line) {
                    Ok(number) => number,
                    Err(fault) => stamp::seconds(cell).map_or_else(
                        || {
                            if column.others.len() < MAX_OTHERS {
                                let cell = shortened(&decoded(cell));
                                column
                                    .others
                                    .push((place, format!("\"{cell}\" is not allowed: {fault}")));
                            }
                            f64::NAN
                        },
                        |seconds| {
                            column.stamps += 1;
                            seconds
                        },
                    ),
                }
            };
            column.values.push(value);
        }
        Ok(())
    }

    /// Leaves out lines that are wider or narrower than the others, where they are few. Of a log in which many are narrower the
    /// cells behind them are empty.
    ///
    /// # Errors
    /// The first that is wider, of many.
    fn leave_out_damaged(&mut self) -> Result<(), LogError> {
        /// The most, part of the lines.
        const MAX_SHARE: f64 = 0.02;
        let rows = self.table.rows() as f64;
        let is_few = |lines: u64| lines as f64 <= MAX_SHARE * rows;
        if let Some(first) = self.damaged.take_if(|_| !is_few(self.table.damaged)) {
            return Err(first);
        }
        if is_few(self.table.damaged + self.narrow.len() as u64) {
            self.table.damaged += self.narrow.len() as u64;
            let narrow = std::mem::take(&mut self.narrow);
            without(&mut self.table.lines, &narrow);
            for column in &mut self.table.columns {
                without(&mut column.values, &narrow);
                column
                    .others
                    .retain(|(of, _)| narrow.binary_search(of).is_err());
                for (of, _) in &mut column.others {
                    *of -= narrow.partition_point(|row| row < of);
                }
            }
        }
        Ok(())
    }

    fn too_wide(&self, row: &csv::ByteRecord) -> String {
        let mut fault = format!(
            "the row cannot be read: it has {} fields where the first row has {}",
            row.len(),
            self.table.columns.len()
        );
        if let Some(other) = self.dialect.others(row.as_slice()) {
            let own = self.dialect.separator_name();
            fault += &format!(
                "; the first row is separated by a {own}, this row by a {other}: use the same separator in all rows"
            );
        } else if self.dialect.separator == b',' {
            fault += "; numbers with decimal commas need semicolons, tabs or quotation marks";
        }
        fault
    }
}

impl TableColumn {
    /// True for text in all cells, and for the numbers of the rows, from 0 or 1.
    fn names_rows(&self) -> bool {
        let are_words = self.values.iter().all(|value| value.is_nan()) && !self.others.is_empty();
        let first = *self.values.first().unwrap_or(&f64::NAN);
        let mut counted = self.values.iter().zip(0_u32..);
        let counts = [0.0, 1.0].contains(&first)
            && counted.all(|(value, row)| (value - first).total_cmp(&f64::from(row)).is_eq());
        are_words || counts || self.stamps == self.values.len()
    }
}

/// The name of a column that has one element of each list. Its unit stays at the end.
fn of_element(name: &str, element: usize) -> String {
    let unit = match name.ends_with([']', ')']) {
        true => name.rfind(['[', '(']),
        false => None,
    };
    match (name, unit) {
        ("", _) => String::new(),
        (_, Some(place)) => format!("{}[{element}] {}", name[..place].trim_end(), &name[place..]),
        (_, None) => format!("{name}[{element}]"),
    }
}

/// The cells of a row but for an empty one behind its last.
fn bare(row: &csv::ByteRecord) -> usize {
    let last = row.iter().next_back();
    row.len() - usize::from(last.is_some_and(|cell| cell.trim_ascii().is_empty()))
}

/// Takes some rows, in their order, out of a column.
fn without<T>(column: &mut Vec<T>, rows: &[usize]) {
    let (mut row, mut next) = (0, rows.iter().peekable());
    column.retain(|_| {
        row += 1;
        next.next_if_eq(&&(row - 1)).is_none()
    });
}

/// A cell as text. One that is not UTF-8 is Latin-1, in which a byte is its character.
fn decoded(cell: &[u8]) -> String {
    match str::from_utf8(cell) {
        Ok(text) => text.to_owned(),
        Err(_) => cell.iter().copied().map(char::from).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::Table;

    fn read(text: &[u8]) -> Result<Table, String> {
        let bytes = std::io::Cursor::new(text.to_vec());
        Table::of_text("log.csv".as_ref(), bytes).map_err(|error| error.to_string())
    }

    fn table(text: &str) -> Table {
        read(text.as_bytes()).unwrap_or_else(|error| panic!("{text:?}: {error}"))
    }

    fn names(table: &Table) -> Vec<&str> {
        table.columns.iter().map(|column| &*column.name).collect()
    }

    fn values(table: &Table) -> Vec<&[f64]> {
        (table.columns.iter())
            .map(|column| &*column.values)
            .collect()
    }

    #[test]
    fn every_column_is_read_with_name_unit_and_numbers() {
        let found = table("t;q;mode\ns;deg;\n06:00:00,5;1,5;on\n06:00:01,5;x;off\n");
        let shape = (found.separator, found.rows(), found.has_heading);
        assert_eq!(shape, (Some("semicolon"), 2, true));
        let [time, position, mode] = &found.columns[..] else {
            panic!("{found:?}");
        };
        assert_eq!((&*time.name, &*time.unit, time.stamps), ("t", "s", 2));
        assert_eq!(time.values, [21_600.5, 21_601.5]);
        assert_eq!((position.unit.as_str(), position.others.len()), ("deg", 1));
        assert_eq!(position.values[..1], [1.5]);
        assert!(position.values[1].is_nan());
        assert_eq!((mode.others.len(), mode.stamps), (2, 0));
        let latin_1 = read(b"t;q;u\n[s];[\xb0];[V]\n0;1;2\n1;2;3\n").expect("a table");
        assert_eq!(latin_1.columns[1].unit, "[°]");
    }

    #[test]
    fn text_is_read_as_people_have_it() {
        let three = vec![vec![0.0, 1.0], vec![1.5, 2.5], vec![-2.0, 3.0]];
        for (text, has_heading) in [
            ("0 1.5  -2\n1 2.5   3\n", false),
            ("t,q,u\n0,1.5,-2\n1,2.5,3\n", true),
            ("# t,q,u\n0,1.5,-2\n1,2.5,3\n", true),
            (
                "Drive 7\nOn: Monday, 9:00\nGain;4,5\n\nt;q;u\n0;1,5;-2\n1;2,5;3\n",
                true,
            ),
            ("t:0,q:1.5,u:-2\nt:1,q:2.5,u:3\n", true),
            ("t: 0 q: 1.5 u: -2\nt: 1 q: 2.5, u: 3,\n", true),
            ("log = [0 1.5 -2;\n1 2.5 3];\n", false),
            ("\"t\",\"q\",\"u\"\n\"0,1.5,-2\"\n\"1,2.5,3\"\n", true),
            ("t,q,u\nstarted\n0,1.5,-2,\n1,2.5,3,\n", true),
        ] {
            let found = table(text);
            assert_eq!(values(&found), three, "{text}");
            assert_eq!(found.has_heading, has_heading, "{text}");
            assert!(!has_heading || names(&found) == ["t", "q", "u"], "{text}");
        }
        let blank = table("t,q,u\n0,,-2\n1,NaN,\n2,3,1\n").columns;
        assert!(blank.iter().all(|one| one.others.is_empty()));
        let [first, second, third] = blank[1].values[..] else {
            panic!("{blank:?}");
        };
        assert!(first.is_nan() && second.is_nan() && (third - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_heading_that_does_not_fit_names_the_rows_or_is_refused() {
        for text in [
            "t,q,u,\n0,1,2\n0.1,2,3\n",
            "t,q,u\n0,1,2,\n0.1,2,3,\n",
            "\nt;q;u;\n0;1;2\n0,1;2;3\n",
        ] {
            assert_eq!(names(&table(text)), ["t", "q", "u"], "{text}");
        }
        for text in [
            "\"t\",\"q\"\n\"1\",0.5,3\n\"2\",0.6,4\n",
            "\tt\tq\n0\t0.5\t3\n1\t0.6\t4\n",
            "t,q\nfirst,0.5,3\nsecond,0.6,4\n",
            "t,q\n06:00:00,0.5,3\n06:00:02,0.6,4\n",
        ] {
            let found = table(text);
            assert_eq!(names(&found), ["", "t", "q"], "{text}");
            assert_eq!(values(&found)[1..], [[0.5, 0.6], [3.0, 4.0]], "{text}");
            assert!(found.notes[0].contains("no name"), "{text}");
        }
        for (text, names) in [
            ("gain 5\nt,q,u,x\n0,1,2\n1,2,3\n", 4),
            ("gain 5\nt,q\n0,1,2\n0.1,2,3\n", 2),
            ("gain 5\nt,q\n2,1,2\n3,2,3\n", 2),
        ] {
            let refused = read(text.as_bytes()).expect_err(text);
            let wrong =
                format!("log.csv:2: this heading has {names} names, but line 3 has 3 cells");
            assert!(refused.starts_with(&wrong), "{refused}");
        }
    }

    #[test]
    fn each_element_of_a_list_is_a_column() {
        for text in [
            "t,q [rad],u\n0,\"[0.1, 0.2]\",[3]\n1,,[4]\n2,\"[0.5, nan]\",[5]\n",
            "t;q [rad];u\n0;(0.1, 0.2);[3]\n1;nan;[4]\n2;(0.5, nan);[5]\n",
            "t\tq [rad]\tu\n0\t[ 0.1 0.2]\t[3.]\n1\t\t[4.]\n2\t[ 0.5  nan]\t[5.]\n",
        ] {
            let found = table(text);
            assert_eq!(names(&found), ["t", "q[0] [rad]", "q[1] [rad]", "u[0]"]);
            assert_eq!(values(&found)[3], [3.0, 4.0, 5.0], "{text}");
            let first = &found.columns[1].values;
            assert!(first[1].is_nan() && first[2] > 0.4, "{first:?}");
        }
        let text = "t,q,u\n0,\"[0.1\n 0.2]\",\"[1\n 2]\"\n1,\"[0.3\n 0.4]\",\"[3\n 4]\"\n";
        let found = table(text);
        assert_eq!(names(&found), ["t", "q[0]", "q[1]", "u[0]", "u[1]"]);
        assert_eq!(
            (values(&found)[4], &found.lines[..]),
            (&[2.0, 4.0][..], &[4, 7][..])
        );
        let found = table("[0.1 0.2],7\n[0.3 0.4],8\n");
        assert_eq!(values(&found), [[0.1, 0.3], [0.2, 0.4], [7.0, 8.0]]);
        let refused = read(b"t,q\n0,[1 2]\n1,[3]\n").expect_err("shorter");
        assert!(
            refused.starts_with("log.csv:3: \"[3]\" is no list of 2"),
            "{refused}"
        );
    }

    #[test]
    fn few_lines_of_many_numbers_are_a_signal_each() {
        let line = |name: &str, from: usize, samples: usize| {
            let numbers = (from..from + samples).map(|k| format!(",{}", k as f64 / 8.0));
            format!("{name}{}\n", numbers.collect::<String>())
        };
        let found = table(&(line("t", 0, 5000) + &line("q", 1, 5000)));
        assert_eq!((names(&found), found.rows()), (vec!["t", "q"], 5000));
        assert_eq!(found.columns[1].values[4998..], [624.875, 625.0]);
        assert_eq!(found.notes, ["a signal a line"]);
        let found = table(&(line("0", 0, 100) + &line("1", 1, 100)));
        assert_eq!((found.rows(), found.has_heading), (101, false));
        let refused = read((line("t", 0, 500) + &line("q", 1, 499)).as_bytes());
        let refused = refused.expect_err("shorter");
        assert!(
            refused.starts_with("log.csv:2: it has 500 cells"),
            "{refused}"
        );
        let many = line("0", 0, 1000).repeat(21);
        let refused = read(many.as_bytes()).expect_err("wide");
        assert!(refused.contains("1001 columns: at most 1000"), "{refused}");
        assert_eq!(table(&line("0", 0, 999).repeat(21)).rows(), 21);
    }

    /// A table of many rows with some lines in the middle.
    fn with_lines(lines: &[&str]) -> Result<Table, String> {
        let row = |k: usize| format!("{k},{},{}\n", k + 1, k + 2);
        let rows = |from: usize| (from..from + 100).map(row).collect::<String>();
        let text = format!("t,q,u\n{}{}\n{}", rows(0), lines.join("\n"), rows(100));
        read(text.as_bytes())
    }

    #[test]
    fn few_lines_of_another_width_are_left_out_and_many_are_a_fault() {
        let damaged = ["1,2,3,4,5", "7", "1;2;3", "1,2,3,4"];
        let found = with_lines(&damaged).expect("a table");
        assert_eq!((found.rows(), found.damaged), (200, 3));
        assert_eq!(found.columns[2].values[101..102], [103.0]);
        assert_eq!((found.lines[99], found.lines[100]), (101, 106));
        let refused = with_lines(&["1,2,3,4,5"; 5]).expect_err("many");
        assert!(refused.contains("log.csv:102:"), "{refused}");
        // Cells that are not there are empty ones.
        let found = with_lines(&["7"; 5]).expect("a table");
        assert_eq!((found.rows(), found.damaged), (205, 0));
    }

    #[test]
    fn a_column_of_times_before_each_signal_is_the_time_of_all() {
        let found = table("q [0x6064],,u,\nX,Y,X,Y\n0.0,5,0.0,1\n1.0,6,,\n2.0,7,2.0,3\n3.0,8,,\n");
        assert_eq!(names(&found), ["time", "q [0x6064]", "u"]);
        assert_eq!(values(&found)[..2], [[0.0, 1.0, 2.0], [5.0, 6.0, 7.0]]);
        assert!(found.columns[2].values[1].is_nan());
        assert_eq!(found.rows(), 3);
        // A channel that was off.
        let found = table("q,,u,,z,\nX,Y,X,Y,X,Y\n0,5,0,1,,\n1,6,1,2,,\n");
        assert_eq!((found.rows(), found.columns.len()), (2, 4));
        let refused = read(b"q,,u,\nX,Y,X,Y\n0,5,0,1\n1,6,1.5,2\n").expect_err("two clocks");
        assert!(refused.contains("line 4"), "{refused}");
    }

    #[test]
    fn files_of_a_signal_each_are_one_table() {
        let file = |name: &str, text: &'static str| {
            Table::of_text(name.as_ref(), text.as_bytes()).expect("a table")
        };
        let q = file("a/q.txt", "1\n2\n3\n");
        let tau = file("a/tau.txt", "tau_m\n4\n5\n6\n");
        let found = Table::of_signals(vec![q.clone(), tau.clone()]).expect("a table");
        assert_eq!(found.len(), 1);
        assert_eq!(names(&found[0]), ["q", "tau_m"]);
        assert_eq!(values(&found[0]), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let short = file("time.txt", "1\n2\n");
        let refused = Table::of_signals(vec![q.clone(), tau, short]).expect_err("shorter");
        assert!(refused.to_string().contains("2 rows"), "{refused}");
        assert_eq!(Table::of_signals(vec![q]).map(|one| one.len()), Ok(1));
    }

    #[test]
    fn columns_in_memory_are_one_length() {
        let of = |name: &str, samples: usize| (name.to_owned(), vec![0.0; samples]);
        let refused = Table::of_columns("log", vec![of("u", 49), of("q", 50)]);
        let refused = refused.expect_err("two lengths");
        assert!(
            refused.starts_with("q has 50 samples but u has 49"),
            "{refused}"
        );
    }
}
