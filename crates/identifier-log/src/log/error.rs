//! Faults of a log, with their place.

use std::fmt;
use std::path::Path;

use crate::scenario::Column;

/// A fault of a log, with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct LogError {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: Option<u64>,
    /// The column.
    pub column: Option<String>,
    /// The fault, the allowed values, and the remedy.
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
    /// An error of a file as a whole.
    pub(super) fn in_file(path: &Path, fault: String) -> Self {
        Self {
            file: path.display().to_string(),
            line: None,
            column: None,
            fault,
        }
    }

    /// An error of a file that is not yet read as a log.
    pub(crate) fn of_file(path: &Path, fault: &str) -> Self {
        Self::in_file(path, fault.to_owned())
    }

    /// An error of a column as a whole.
    pub(super) fn in_column(path: &Path, column: &Column, fault: String) -> Self {
        Self {
            column: Some(column.to_string()),
            ..Self::in_file(path, fault)
        }
    }

    /// An error of a line, perhaps of one column there.
    pub(super) fn at_line(path: &Path, line: u64, column: Option<&str>, fault: String) -> Self {
        Self {
            line: Some(line),
            column: column.map(str::to_owned),
            ..Self::in_file(path, fault)
        }
    }
}

/// A text of a log as a message repeats it.
pub(super) fn shortened(text: &str) -> String {
    crate::nearest::shortened(text, 80)
}
