//! The rows of a log, one at a time: columns, numbers, and bounds on all that is read.

use std::cell::Cell;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::rc::Rc;

use flate2::read::MultiGzDecoder;

use crate::scenario::LogSettings;

/// The longest row, bytes, whatever a file unpacks to.
const LONGEST_ROW: usize = 1 << 20;

/// The most columns of a log.
const MOST_COLUMNS: usize = 1000;

/// The most rows of a log.
const MOST_ROWS: u64 = 1_000_000_000;

/// One sample of a log, in the log's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// The line of the file, from 1, the heading among them; of a bridged sample, the line after
    /// the gap.
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
}

/// What is wrong with a log, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct LogError {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: Option<u64>,
    /// The column.
    pub column: Option<String>,
    /// What is wrong, what is allowed, what to do.
    pub fault: String,
}

impl fmt::Display for LogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ": column {column}")?;
        }
        write!(f, ": {}", self.fault)
    }
}

impl std::error::Error for LogError {}

impl LogError {
    /// Of a file as a whole.
    pub(super) fn of_file(path: &Path, fault: String) -> Self {
        Self {
            file: path.display().to_string(),
            line: None,
            column: None,
            fault,
        }
    }

    /// Of a line, perhaps of one column there.
    pub(super) fn of_line(path: &Path, line: u64, column: Option<&str>, fault: String) -> Self {
        Self {
            line: Some(line),
            column: column.map(str::to_owned),
            ..Self::of_file(path, fault)
        }
    }
}

/// Reads a file row by row, of which there is never more than one in memory.
pub(super) struct Rows<'a> {
    path: &'a Path,
    columns: Columns<'a>,
    reader: csv::Reader<Bounded<Box<dyn Read>>>,
    row: csv::ByteRecord,
    /// Bytes that the file may still give before the next row ends.
    allowance: Rc<Cell<usize>>,
    read: u64,
}

/// Where the columns stand, with their names.
struct Columns<'a> {
    time: (usize, &'a str),
    reference: Option<(usize, &'a str)>,
    position: (usize, &'a str),
    command: Option<(usize, &'a str)>,
    injection: Option<(usize, &'a str)>,
}

impl<'a> Rows<'a> {
    /// Opens a `.csv` or `.csv.gz` file and finds its columns.
    ///
    /// # Errors
    /// The file, or the column that it has not got.
    pub(super) fn open(path: &'a Path, settings: &'a LogSettings) -> Result<Self, LogError> {
        let unreadable =
            |error: io::Error| LogError::of_file(path, format!("the log cannot be read: {error}"));
        let file = File::open(path).map_err(unreadable)?;
        if !file.metadata().map_err(unreadable)?.is_file() {
            return Err(LogError::of_file(
                path,
                "a log is read more than once, so it must be a file: save what comes through a pipe \
                 first"
                    .to_owned(),
            ));
        }
        let packed = path.extension().is_some_and(|end| end == "gz");
        let text: Box<dyn Read> = if packed {
            Box::new(MultiGzDecoder::new(BufReader::new(file)))
        } else {
            Box::new(file)
        };
        Self::of_text(path, text, settings)
    }

    fn of_text(
        path: &'a Path,
        text: Box<dyn Read>,
        settings: &'a LogSettings,
    ) -> Result<Self, LogError> {
        /// Bytes that are read at once.
        const AT_ONCE: usize = 1 << 16;
        let allowance = Rc::new(Cell::new(LONGEST_ROW));
        let mut reader = csv::ReaderBuilder::new()
            .buffer_capacity(AT_ONCE)
            .from_reader(Bounded {
                inner: text,
                allowance: Rc::clone(&allowance),
            });
        let heading: Vec<String> = reader
            .byte_headers()
            .map_err(|error| {
                let fault = format!("no heading can be read: {}", explained(&error));
                LogError::of_line(path, 1, None, fault)
            })?
            .iter()
            .map(|name| String::from_utf8_lossy(name.trim_ascii()).into_owned())
            .collect();
        if heading.len() > MOST_COLUMNS {
            return Err(LogError::of_line(
                path,
                1,
                None,
                format!(
                    "the log has {} columns: at most {MOST_COLUMNS} are allowed",
                    heading.len()
                ),
            ));
        }
        let place = |column: &'a str| {
            let place = heading.iter().position(|name| name == column);
            place.map(|place| (place, column)).ok_or_else(|| {
                let known = shortened(&heading.join(", "));
                let fault = format!(
                    "the log has no such column, but {known}: [log] in the scenario says which \
                     column is what"
                );
                LogError::of_line(path, 1, Some(column), fault)
            })
        };
        let optional = |column: &'a Option<String>| column.as_deref().map(place).transpose();
        let columns = Columns {
            time: place(&settings.time)?,
            reference: optional(&settings.reference)?,
            position: place(&settings.position)?,
            command: optional(&settings.command)?,
            injection: optional(&settings.injection)?,
        };
        Ok(Self {
            path,
            columns,
            reader,
            row: csv::ByteRecord::new(),
            allowance,
            read: 0,
        })
    }

    /// Reads the next row; false after the last.
    fn advance(&mut self) -> Result<bool, LogError> {
        self.allowance.set(LONGEST_ROW);
        let line = self.reader.position().line();
        let there = self
            .reader
            .read_byte_record(&mut self.row)
            .map_err(|error| {
                let fault = format!("the row cannot be read: {}", explained(&error));
                let line = error.position().map_or(line, csv::Position::line);
                LogError::of_line(self.path, line, None, fault)
            })?;
        self.read += u64::from(there);
        if self.read > MOST_ROWS {
            let fault = format!("the log has more than {MOST_ROWS} rows: divide it");
            return Err(LogError::of_line(self.path, line, None, fault));
        }
        Ok(there)
    }

    fn record(&self) -> Result<Record, LogError> {
        let line = self.row.position().map_or(0, csv::Position::line);
        let number = |(index, column): (usize, &str)| {
            let field = self.row.get(index).unwrap_or_default().trim_ascii();
            let value = std::str::from_utf8(field)
                .ok()
                .and_then(|field| field.parse().ok());
            value
                .filter(|value: &f64| value.is_finite())
                .ok_or_else(|| {
                    let field = shortened(&String::from_utf8_lossy(field));
                    let fault = format!("\"{field}\" is not allowed: it must be any finite number");
                    LogError::of_line(self.path, line, Some(column), fault)
                })
        };
        let columns = &self.columns;
        Ok(Record {
            line,
            time: number(columns.time)?,
            reference: columns.reference.map(number).transpose()?,
            position: number(columns.position)?,
            command: columns.command.map(number).transpose()?,
            injection: columns.injection.map_or(Ok(0.0), number)?,
            bridged: false,
        })
    }
}

impl Iterator for Rows<'_> {
    type Item = Result<Record, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.advance() {
            Ok(true) => Some(self.record()),
            Ok(false) => None,
            Err(error) => Some(Err(error)),
        }
    }
}

/// Reads until the allowance is used up, so that no row fills the memory, whatever a few packed bytes
/// unpack to.
struct Bounded<R> {
    inner: R,
    allowance: Rc<Cell<usize>>,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let allowed = self.allowance.get();
        if allowed == 0 {
            return Err(io::Error::other(format!(
                "it is longer than {LONGEST_ROW} bytes: is a quotation mark or a line's end missing?"
            )));
        }
        let most = buffer.len().min(allowed);
        let read = self.inner.read(&mut buffer[..most])?;
        self.allowance.set(allowed - read);
        Ok(read)
    }
}

/// What a reader complains of.
fn explained(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Io(error) => error.to_string(),
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!("it has {len} fields where the heading has {expected_len}"),
        _ => error.to_string(),
    }
}

/// A text of a log as a message may repeat it: not long, and without control characters.
fn shortened(text: &str) -> String {
    const MOST: usize = 80;
    let shown = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut short: String = text.chars().map(shown).take(MOST).collect();
    if text.chars().nth(MOST).is_some() {
        short.push('…');
    }
    short
}
