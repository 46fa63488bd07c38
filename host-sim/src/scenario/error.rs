use std::fmt;
use std::path::Path;

/// Where a scenario is wrong, and what is allowed there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScenarioError {
    /// The file.
    pub file: String,
    /// The line, from 1; none when the file could not be read.
    pub line: Option<usize>,
    /// The path of the key.
    pub key: Option<String>,
    /// What is wrong.
    pub fault: String,
    /// What is allowed.
    pub allowed: Option<String>,
}

impl ScenarioError {
    pub(super) fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        Self {
            file: path.display().to_string(),
            line: None,
            key: None,
            fault: format!("the scenario cannot be read: {error}"),
            allowed: None,
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
        if let Some(allowed) = &self.allowed {
            write!(f, "\n  allowed: {allowed}")?;
        }
        Ok(())
    }
}

impl std::error::Error for ScenarioError {}

/// A fault of the contents, before it is known where in the file it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    pub(crate) key: String,
    pub(crate) fault: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key, self.fault)
    }
}

impl Fault {
    pub(crate) fn new(key: impl Into<String>, fault: impl fmt::Display) -> Self {
        Self {
            key: key.into(),
            fault: fault.to_string(),
        }
    }
}
