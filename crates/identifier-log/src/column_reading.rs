//! How the columns of a log were read, as data: what builds on a result takes it from here.

use std::fmt;

use serde::{Deserialize, Serialize};

/// How the columns of a log were read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// The time of the rows.
    pub time: ColumnReading,
    /// The measured position, or velocity.
    pub position: ColumnReading,
    /// The command; none where the servo's own loop computes it from its goals.
    pub command: Option<CommandReading>,
    /// What was assumed because nothing shows it, a sentence each.
    pub assumed: Vec<String>,
}

/// How a column was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ColumnReading {
    /// Its name, or its number where it has none; none of a time that is that of the rows.
    pub column: Option<String>,
    /// Its unit as written; none where nothing states it.
    pub unit: Option<String>,
    /// Units for one of the column's.
    pub factor: f64,
    /// Why it is taken for what it is, and in this unit.
    pub evidence: String,
}

/// How the command was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CommandReading {
    /// The column, and its factor without a sign.
    #[serde(flatten)]
    pub of: ColumnReading,
    /// Its sign.
    pub sign: CommandSign,
}

/// The sign of a command in relation to its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CommandSign {
    /// That of the column.
    AsLogged,
    /// Inverted, as stated.
    Stated,
    /// Inverted, since the motion goes against the column.
    Inferred,
}

impl Reading {
    /// In lines for a reader.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let command = match &self.command {
            Some(command) => format!("command: {}{}", command.of, command.sign),
            None => "command: computed by the servo's own loop from its goals".to_owned(),
        };
        let mut lines = vec![format!("position: {}", self.position), command];
        lines.extend(
            self.assumed
                .iter()
                .map(|of| format!("not shown by the log: {of}")),
        );
        lines
    }
}

impl fmt::Display for ColumnReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let column = self.column.as_deref().unwrap_or("none");
        let unit = self.unit.as_deref().unwrap_or("its own unit");
        write!(f, "column {column}, in {unit}")?;
        if (self.factor - 1.0).abs() > 0.0 {
            write!(f, ", times {}", self.factor)?;
        }
        write!(f, " ({})", self.evidence)
    }
}

impl fmt::Display for CommandSign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AsLogged => "",
            Self::Stated => ", inverted as stated",
            Self::Inferred => ", inverted because the motion goes against it",
        })
    }
}
