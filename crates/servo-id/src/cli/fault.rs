use std::fmt;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::process::ExitCode;

use host_sim::scenario::ScenarioError;

use super::interruption::INTERRUPTED;

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub(super) enum Fault {
    /// The user's input is wrong: exit status 2.
    #[error("{0}")]
    Input(String),
    /// The verdict is not the required one: exit status 3.
    #[error("{0}")]
    Unmet(String),
    /// The user ended it, with what was known until then: exit status 130.
    #[error("{0}")]
    Interrupted(String),
    /// Something else failed: exit status 1.
    #[error("{0}")]
    Other(String),
}

impl Fault {
    pub(super) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Unmet(_) => ExitCode::from(3),
            Self::Interrupted(_) => ExitCode::from(INTERRUPTED),
            Self::Other(_) => ExitCode::from(1),
        }
    }

    /// The same, with what followed.
    #[cfg(feature = "operation")]
    pub(super) fn and(mut self, what: impl fmt::Display) -> Self {
        let (Self::Input(text) | Self::Unmet(text) | Self::Interrupted(text) | Self::Other(text)) =
            &mut self;
        *text = format!("{text}; {what}");
        self
    }

    /// A fault of the content of a file.
    pub(super) fn of_file(file: &Path, fault: impl fmt::Display) -> Self {
        Self::Input(format!("{}: {fault}", file.display()))
    }

    /// A place that was asked for and where nothing can be written.
    pub(super) fn unusable(name: impl fmt::Display, error: &io::Error) -> Self {
        Self::Input(cannot_be_written(name, error))
    }

    /// A place where not all could be written.
    pub(super) fn unwritable(name: impl fmt::Display, error: &io::Error) -> Self {
        Self::Other(cannot_be_written(name, error))
    }
}

fn cannot_be_written(name: impl fmt::Display, error: &io::Error) -> String {
    let text = error.to_string();
    let why = match error.kind() {
        ErrorKind::NotFound => "there is no such folder",
        ErrorKind::NotADirectory => "its folder is a file",
        ErrorKind::PermissionDenied => "permission denied",
        ErrorKind::AlreadyExists => "the file exists",
        ErrorKind::StorageFull => "no space left",
        // Without the number that the system has for it.
        _ => text.split(" (os error").next().unwrap_or(&text),
    };
    format!("{name} cannot be written: {why}")
}

impl From<ScenarioError> for Fault {
    fn from(error: ScenarioError) -> Self {
        Self::Input(error.to_string())
    }
}
