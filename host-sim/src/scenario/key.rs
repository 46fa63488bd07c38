//! A key of a scenario: the columns of the table [`KEYS`](super::keys::KEYS).

use super::error::shown;
use super::keys::KEYS;
use super::kind::{Choice, Kind};

/// A key: a line of the table.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its path, table and key.
    pub path: &'static str,
    /// The kind of its value, and the place of the value in the scenario.
    pub(super) kind: Kind,
    /// The default.
    pub(super) default: Default,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// Its meaning, in one sentence.
    pub about: &'static str,
}

/// The value of an absent key.
#[derive(Debug, Clone, Copy)]
pub(super) enum Default {
    /// Nothing: the key is required; this value is shown as an example.
    Required(&'static str),
    /// This number.
    Value(f64),
    /// This initial estimate; the laws that fit need none.
    Initial(f64),
    /// The first choice.
    FirstChoice,
    /// A value that is derived from something else.
    Derived(&'static str),
}

impl Key {
    /// The line of a path.
    #[must_use]
    pub fn at(path: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.path == path)
    }

    /// The key that a name or a path is most likely meant to be, wherever it stands.
    #[must_use]
    pub fn nearest(word: &str) -> Option<&'static Self> {
        let named = KEYS.iter().find(|key| key.place().1 == word);
        named.or_else(|| Self::at(nearest(word, KEYS.iter().map(|key| key.path))?))
    }

    /// The path of its table, empty for a table of the file, and its name in it.
    #[must_use]
    pub fn place(&self) -> (&'static str, &'static str) {
        self.path.rsplit_once('.').unwrap_or(("", self.path))
    }

    /// The heading of its table in a file, for a key that is one.
    #[must_use]
    pub fn heading(&self) -> String {
        match self.kind {
            Kind::Tables(_) => format!("[[{}]]", self.path),
            _ => format!("[{}]", self.path),
        }
    }

    /// The keys of a table; for the empty path, the tables.
    pub fn children(table: &str) -> impl Iterator<Item = &'static Self> {
        KEYS.iter().filter(move |key| key.place().0 == table)
    }

    /// True for a table of further keys.
    pub(super) fn is_table(&self) -> bool {
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
            Default::Initial(number) => format!("{number}; a law that fits needs none"),
            Default::FirstChoice => {
                let first = self.kind.choices().first();
                first.map_or(String::new(), |first| format!("\"{}\"", first.name))
            }
            Default::Derived(text) => text.to_owned(),
        }
    }

    /// The names, of a key beside, that it belongs to; empty for a key that always holds.
    #[must_use]
    pub fn belongs_to(&self) -> Vec<&'static str> {
        let (table, name) = self.place();
        Self::children(table)
            .flat_map(|key| key.kind.choices())
            .filter(|choice| choice.takes.contains(&name))
            .map(|choice| choice.name)
            .collect()
    }

    /// Its meaning, and the choices that it belongs to.
    #[must_use]
    pub fn description(&self) -> String {
        match self.belongs_to() {
            owners if owners.is_empty() => self.about.to_owned(),
            owners => format!("{} ({})", self.about, owners.join(", ")),
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
pub(super) fn examples(keys: impl Iterator<Item = &'static Key>) -> String {
    let lines: String = keys
        .filter_map(Key::example)
        .map(|line| format!("  {line}\n"))
        .collect();
    match lines.is_empty() {
        true => lines,
        false => format!("write, for example:\n{lines}"),
    }
}

/// The name that a word is most likely meant to be.
pub(super) fn nearest<'n>(word: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    crate::nearest::name(&shown(word), names)
}
