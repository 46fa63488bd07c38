//! A kept result, read back.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::Value;

use super::difference::differences;
use super::{LogFile, Origin};

/// A kept result.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// The file it was read from.
    pub file: PathBuf,
    /// Its origin.
    pub origin: Origin,
    /// The result itself, if the file holds it.
    pub result: Option<Value>,
}

/// Why a result cannot be reproduced.
#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    /// The file cannot be read.
    #[error("the result cannot be read: {0}")]
    Unreadable(io::Error),
    /// It is of a kind that is no longer read: what replaces it.
    #[error("{0}")]
    Gone(&'static str),
    /// It is no JSON.
    #[error(
        "this is not a result: give a file that run, identify or commission wrote with --json, or the -metadata.json \
         of a CSV trace"
    )]
    NoResult,
    /// It has no origin.
    #[error(
        "the file has no provenance: only results of run, identify and commission can be reproduced, from version \
         0.1.0 on"
    )]
    NoOrigin,
    /// A log is missing.
    #[error(
        "the log of this result, {}, is missing: restore it there, or next to the result",
        .0.display()
    )]
    NoLog(PathBuf),
    /// A log has changed.
    #[error(
        "{} is not the log of the result: its SHA-256 differs; restore the original log",
        .0.display()
    )]
    OtherLog(PathBuf),
}

impl Kept {
    /// Largest result in JSON, bytes.
    const MAX_SIZE: u64 = 1 << 26;

    /// Reads a result.
    ///
    /// # Errors
    /// Why it cannot be reproduced.
    pub fn read(file: &Path) -> Result<Self, KeptError> {
        let mut bytes = Vec::new();
        File::open(file)
            .and_then(|opened| opened.take(Self::MAX_SIZE).read_to_end(&mut bytes))
            .map_err(KeptError::Unreadable)?;
        let Ok(Value::Object(mut result)) = serde_json::from_slice(&bytes) else {
            return Err(KeptError::NoResult);
        };
        let origin = result.remove("origin").ok_or(KeptError::NoOrigin)?;
        Ok(Self {
            file: file.to_owned(),
            origin: serde_json::from_value(origin).map_err(|_| KeptError::NoOrigin)?,
            // A description of a trace has no result.
            result: result.contains_key("status").then(|| result.into()),
        })
    }

    /// A log of the result: at its former place, or beside the result.
    ///
    /// # Errors
    /// If it is missing, or has changed.
    pub fn log(&self, kept: &LogFile) -> Result<PathBuf, KeptError> {
        let beside = self.file.parent().unwrap_or(Path::new(""));
        let mut places = [
            Some(kept.file.clone()),
            kept.file.file_name().map(|name| beside.join(name)),
        ]
        .into_iter()
        .flatten()
        .filter(|place| place.is_file())
        .peekable();
        let Some(first) = places.peek().cloned() else {
            return Err(KeptError::NoLog(kept.file.clone()));
        };
        for place in places {
            let found = LogFile::read(&place).map_err(KeptError::Unreadable)?;
            if found.sha256 == kept.sha256 {
                return Ok(place);
            }
        }
        Err(KeptError::OtherLog(first))
    }

    /// The differences of another result from this one, key by key; `None` if this one is not known.
    ///
    /// # Errors
    /// If the other cannot be written as JSON.
    pub fn differences(
        &self,
        other: &impl Serialize,
    ) -> Result<Option<Vec<String>>, serde_json::Error> {
        // As it is read from a file, and not as it is in memory.
        let other = serde_json::from_str(&serde_json::to_string(other)?)?;
        let result = self.result.as_ref();
        Ok(result.map(|result| differences(result, &other)))
    }
}
