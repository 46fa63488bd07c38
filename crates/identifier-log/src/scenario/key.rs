//! A key of a scenario: the columns of the table `KEYS`.

use super::Document;
use super::kind::{Choice, Default, Key, Kind};

impl<S> Key<S> {
    /// The path of its table, empty for a table of the file, and its name in it.
    #[must_use]
    pub fn place(&self) -> (&'static str, &'static str) {
        self.path.rsplit_once('.').unwrap_or(("", self.path))
    }
}

impl<S: Document> Key<S> {
    /// The heading of its table in a file, for a key that is one.
    #[must_use]
    pub fn heading(&self) -> String {
        match &self.kind {
            Kind::Tables(_) => format!("[[{}]]", self.path),
            _ => format!("[{}]", self.path),
        }
    }

    /// True for a table of further keys.
    #[must_use]
    pub fn is_table(&self) -> bool {
        matches!(self.kind, Kind::Table(_))
    }

    /// Its allowed values, in words.
    #[must_use]
    pub fn allowed(&self) -> String {
        self.kind.allowed(self)
    }

    /// Its default, in words.
    #[must_use]
    pub fn default(&self) -> String {
        match self.default {
            Default::Required(_) => "none, it is required".to_owned(),
            Default::Value(number) => number.to_string(),
            Default::Initial(number) => format!("{number}; an estimator that fits needs none"),
            Default::FirstChoice => {
                let first = self.kind.choices().first();
                first.map_or(String::new(), |first| format!("\"{}\"", first.name))
            }
            Default::Derived(text) => text.to_owned(),
        }
    }

    /// True if a choice of a key beside this one leaves it without meaning.
    pub(super) fn is_foreign_to(&self, choice: &Choice, choices: &[Choice]) -> bool {
        let takes = |choice: &Choice| choice.takes.contains(&self.place().1);
        !takes(choice) && choices.iter().any(takes)
    }

    /// A line to copy, for a key that is required.
    pub(super) fn example(&self) -> Option<String> {
        let Default::Required(example) = self.default else {
            return None;
        };
        let unit = match self.unit {
            "" => String::new(),
            unit => format!("{unit}; "),
        };
        let (_, name) = self.place();
        Some(format!("{name} = {example}   # {unit}{}", self.about))
    }
}

/// Lines to copy, for those of some keys that are required; empty if none is.
pub fn examples<S: Document>(keys: impl Iterator<Item = &'static Key<S>>) -> String {
    let lines: String = keys
        .filter_map(Key::example)
        .map(|line| format!("  {line}\n"))
        .collect();
    match lines.is_empty() {
        true => lines,
        false => format!("write, for example:\n{lines}"),
    }
}
