use std::fmt;

/// Where a scenario is wrong, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScenarioError {
    /// The file.
    pub file: String,
    /// The line, from 1; none when the file could not be read.
    pub line: Option<usize>,
    /// The path of the key.
    pub key: Option<String>,
    /// The fault.
    pub fault: String,
    /// The allowed values and the remedy, line by line; may be empty.
    pub advice: String,
}

impl ScenarioError {
    pub(super) fn new(file: &str, line: Option<usize>, key: Option<String>, fault: String) -> Self {
        Self {
            file: file.to_owned(),
            line,
            key,
            fault,
            advice: String::new(),
        }
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(key) = &self.key {
            write!(f, ": {key}")?;
        }
        write!(f, ": {}", self.fault)?;
        for line in self.advice.lines() {
            write!(f, "\n  {line}")?;
        }
        Ok(())
    }
}

impl std::error::Error for ScenarioError {}

/// A fault of the contents, before its line in the file is known.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {fault}")]
pub struct Fault {
    /// The path of the key.
    pub key: String,
    /// What is wrong.
    pub fault: String,
    /// Its byte in the file, if that is not simply its key's.
    pub(super) at: Option<usize>,
    pub(super) advice: String,
}

impl Fault {
    /// A fault at a key, given by its path.
    pub fn new(key: impl Into<String>, fault: impl fmt::Display) -> Self {
        Self {
            key: key.into(),
            fault: fault.to_string(),
            at: None,
            advice: String::new(),
        }
    }

    pub(super) fn at(self, byte: usize) -> Self {
        Self {
            at: Some(byte),
            ..self
        }
    }

    /// At this byte, if it is not known to stand elsewhere.
    pub(super) fn or_at(self, byte: usize) -> Self {
        Self {
            at: self.at.or(Some(byte)),
            ..self
        }
    }

    pub(super) fn advising(self, advice: String) -> Self {
        Self { advice, ..self }
    }
}

/// A piece of a scenario as a message repeats it.
pub(super) fn shown(text: &str) -> String {
    crate::nearest::shortened(text, 40)
}
