//! Where the rows of a log come from: a text, or messages.

use std::path::Path;

use super::dialect::Dialect;
use super::error::LogError;
use super::messages::{Layout, MessageRows};
use super::rows::{Record, TextRows};
use crate::log_file;
use crate::scenario::LogSettings;

/// How a log is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Format {
    /// `.csv`, `.csv.gz`.
    Text(Dialect),
    /// `.mcap`.
    Messages(Layout),
}

/// The rows of a log, one at a time, in SI.
pub(super) enum Rows<'a> {
    Text(Box<TextRows<'a>>),
    Messages(Box<MessageRows<'a>>),
}

impl Format {
    /// Finds it out.
    ///
    /// # Errors
    /// The file that cannot be read; of messages, the column that is not there.
    pub(super) fn of_file(path: &Path, settings: &LogSettings) -> Result<Self, LogError> {
        if path.is_file() && log_file::is_mcap(path) {
            Layout::of_file(path, settings).map(Self::Messages)
        } else {
            Dialect::of_file(path).map(Self::Text)
        }
    }

    /// What separates the columns of a text, by name.
    pub(super) fn separator_name(&self) -> Option<&'static str> {
        match self {
            Self::Text(dialect) => Some(dialect.separator_name()),
            Self::Messages(_) => None,
        }
    }
}

impl<'a> Rows<'a> {
    /// Opens a file; without stamps, its rows are `sample_time` (s) apart.
    ///
    /// # Errors
    /// The file, or the column that it has not got.
    pub(super) fn open(
        path: &'a Path,
        settings: &'a LogSettings,
        format: &'a Format,
        sample_time: f64,
    ) -> Result<Self, LogError> {
        Ok(match format {
            Format::Text(dialect) => Self::Text(Box::new(TextRows::open(
                path,
                settings,
                *dialect,
                sample_time,
            )?)),
            Format::Messages(layout) => Self::Messages(Box::new(MessageRows::open(
                path,
                settings,
                layout,
                sample_time,
            )?)),
        })
    }

    /// Rows that were left out.
    pub(super) fn left_out(&self) -> u64 {
        match self {
            Self::Text(rows) => rows.left_out,
            Self::Messages(rows) => rows.left_out,
        }
    }

    /// Whether the numbers were found to have decimal commas.
    pub(super) fn has_decimal_commas(&self) -> bool {
        matches!(self, Self::Text(rows) if rows.has_decimal_commas())
    }

    /// What the row of units says, if there is one.
    pub(super) fn units_row(&self) -> Option<&String> {
        match self {
            Self::Text(rows) => rows.units_row.as_ref(),
            Self::Messages(_) => None,
        }
    }
}

impl Iterator for Rows<'_> {
    type Item = Result<Record, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self {
            Self::Text(rows) => rows.next(),
            Self::Messages(rows) => rows.next(),
        }
    }
}
