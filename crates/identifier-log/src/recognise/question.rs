use super::LogOptions;
use crate::log::Table;

/// A fact that a log does not show and its user knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// The option that answers it.
    pub flag: &'static str,
    /// The unknown fact, and the allowed answers.
    pub text: String,
}

impl Question {
    /// The refusal of a log where nobody answers, with the option that is missing or that states no column of the log.
    #[must_use]
    pub fn refusal(&self, stated: &LogOptions, log: &Table) -> String {
        let Self { flag, text } = self;
        let column = match *flag {
            "time" => &stated.time,
            "position" => &stated.position,
            "command" => &stated.command,
            "reference" => &stated.reference,
            "goal" => &stated.goal,
            "velocity" => &stated.velocity,
            "known-torque" => &stated.known_torque,
            _ => &None,
        };
        let is_column = |name: &str| {
            let number = name.parse::<usize>().unwrap_or(0);
            (1..=log.columns.len()).contains(&number)
                || log.columns.iter().any(|column| column.name == name)
        };
        let wrong = column.as_ref().filter(|name| !is_column(name));
        let fault = wrong.map_or_else(
            || "is missing".to_owned(),
            |name| format!("{name} is not a column"),
        );
        format!("{}: --{flag} {fault}: {text}", log.path.display())
    }
}
