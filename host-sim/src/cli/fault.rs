use std::fmt;
use std::path::Path;
use std::process::ExitCode;

use crate::report::plot::PlotError;
use crate::scenario::ScenarioError;

/// Why a verb did not do what it was asked.
#[derive(Debug)]
pub(super) enum Fault {
    /// The user's input is wrong: exit status 2.
    Input(String),
    /// Something else failed: exit status 1.
    Other(String),
}

impl Fault {
    pub(super) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Other(_) => ExitCode::from(1),
        }
    }

    /// A file that could not be written.
    pub(super) fn unwritable(path: &Path, error: impl fmt::Display) -> Self {
        Self::Other(format!("{} cannot be written: {error}", path.display()))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(text) | Self::Other(text) => f.write_str(text),
        }
    }
}

impl From<ScenarioError> for Fault {
    fn from(error: ScenarioError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<PlotError> for Fault {
    fn from(error: PlotError) -> Self {
        match error {
            PlotError::Format => Self::Input(error.to_string()),
            _ => Self::Other(error.to_string()),
        }
    }
}
