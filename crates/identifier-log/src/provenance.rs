//! The origin of a result.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

#[cfg(feature = "files")]
use crate::log::{Table, fingerprint};
use crate::scenario::{ScenarioError, fetch};

/// The origin of a result: all that it takes to get it again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// The version of the program.
    pub version: String,
    /// The command line.
    pub command: Vec<String>,
    /// The experiment.
    #[serde(flatten)]
    pub task: Task,
    /// The scenario, whole.
    pub scenario: ScenarioText,
    /// The seed of the random effects in servo and sensor.
    pub seed: u32,
}

/// The experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "verb", rename_all = "kebab-case")]
pub enum Task {
    /// An experiment on the simulated servo.
    Run,
    /// Identification from logs.
    Replay {
        /// Passes over the logs.
        passes: u32,
        /// The logs, in their order.
        logs: Vec<LogFile>,
        /// Those that were predicted.
        predict: Vec<LogFile>,
    },
    /// A commissioning of the simulated drive.
    Commission,
}

/// The text of a scenario.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScenarioText {
    /// The file.
    pub file: String,
    /// Its text.
    pub text: String,
}

/// A log that was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogFile {
    /// The file.
    pub file: PathBuf,
    /// The SHA-256 of its content.
    pub sha256: String,
}

/// A result with its origin; without a result, the description beside a trace that cannot hold its origin.
#[derive(Debug, Serialize)]
pub struct WithOrigin<'a, D> {
    /// The result.
    #[serde(flatten)]
    pub result: Option<&'a D>,
    /// Its origin.
    pub origin: &'a Origin,
}

impl Origin {
    /// The origin of the present call of a program in a version.
    #[must_use]
    pub fn new(version: &str, task: Task, text: &ScenarioText, seed: u32) -> Self {
        Self {
            version: version.to_owned(),
            command: std::env::args_os()
                .map(|argument| argument.to_string_lossy().into_owned())
                .collect(),
            task,
            scenario: text.clone(),
            seed,
        }
    }
}

impl ScenarioText {
    /// Reads a file.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        Ok(Self {
            file: path.display().to_string(),
            text: fetch(path)?,
        })
    }

    /// The same with an entry at the beginning of a table.
    #[must_use]
    pub fn stating(mut self, table: &str, entry: &str) -> Self {
        let header = format!("[{table}]");
        let mut end = 0;
        for line in self.text.split_inclusive('\n') {
            end += line.len();
            if line.trim_start().starts_with(&header) {
                self.text.insert_str(end, &format!("\n{entry}\n"));
                break;
            }
        }
        self
    }
}

#[cfg(feature = "files")]
impl LogFile {
    /// Those of tables, but for columns that come from no file.
    #[must_use]
    pub fn of_tables(tables: &[Table]) -> Vec<Self> {
        let read = tables.iter().filter_map(|table| {
            Some(Self {
                file: table.path.clone(),
                sha256: (table.sha256.clone()).or_else(|| fingerprint::of_file(&table.path))?,
            })
        });
        read.collect()
    }
}
