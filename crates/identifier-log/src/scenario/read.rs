//! From the text of a scenario to its settings, key by key.

use std::f64::consts::PI;

use toml::de::{DeTable, DeValue};

use super::Document;
use super::error::{Fault, ScenarioError, shown};
use super::key::examples;
use super::kind::{self, Choice, Default, Entries, Key, Kind, Value, nearest};
use super::range::Range;
use super::source::Source;

/// Reads a text into a document of which nothing is stated yet, and checks it by `complete`. Errors show `name` as the file.
///
/// # Errors
/// File, line, key and what is allowed there.
pub fn read<S: Document>(
    blank: S,
    name: &str,
    text: &str,
    complete: impl FnOnce(S) -> Result<S, Fault>,
) -> Result<S, ScenarioError> {
    let source = Source::new(name, text)?;
    document(&source, blank)
        .and_then(complete)
        .map_err(|fault| source.locate::<S>(fault))
}

/// A blank document with what a file states; keys that it does not state have their defaults.
fn document<S: Document>(source: &Source<'_>, blank: S) -> Result<S, Fault> {
    if S::IS_WHOLE {
        refuse_unknown::<S>(&source.root, "")?;
    }
    let mut reading = Reading {
        source,
        document: blank,
        tables: vec![""],
        choices: Vec::new(),
        entry: None,
    };
    for key in S::keys() {
        reading.read(key)?;
    }
    if !reading.tables.contains(&"controller") {
        reading.document.as_mut().stated.controller = None;
    }
    Ok(reading.document)
}

/// A file that is being read.
struct Reading<'a, 'b, S> {
    source: &'b Source<'a>,
    document: S,
    /// Tables whose keys hold.
    tables: Vec<&'static str>,
    /// The choices made, each with its table and its alternatives.
    choices: Vec<(&'static str, &'static Choice, &'static [Choice])>,
    /// The current table among those that may occur several times, and its path.
    entry: Option<(&'static str, &'b DeTable<'a>)>,
}

impl<'a, 'b, S: Document> Reading<'a, 'b, S> {
    fn read(&mut self, key: &'static Key<S>) -> Result<(), Fault> {
        if !self.tables.contains(&key.place().0) {
            return Ok(());
        }
        match (self.refusing(key), self.value(key)) {
            (Some(choice), Some(value)) => {
                Err(key_not_applicable(key, choice).at(value.span().start))
            }
            (Some(_), None) => Ok(()),
            (None, Some(value)) => self.take(key, value),
            (None, None) => self.take_default(key),
        }
    }

    /// The value of a key in the file.
    fn value(&self, key: &Key<S>) -> Option<&'b Value<'a>> {
        let (table, name) = key.place();
        match self.entry {
            Some((path, entry)) if path == table => entry.get(name),
            _ => self.source.value(key.path),
        }
    }

    /// The choice that leaves a key without meaning, if one does.
    fn refusing(&self, key: &Key<S>) -> Option<&'static Choice> {
        let mut made = self.choices.iter();
        made.find_map(|(table, choice, choices)| {
            let foreign = *table == key.place().0 && key.is_foreign_to(choice, choices);
            foreign.then_some(*choice)
        })
    }

    /// A key that the file states.
    fn take(&mut self, key: &'static Key<S>, value: &'b Value<'a>) -> Result<(), Fault> {
        match &key.kind {
            Kind::Table(_) => {
                check_table(key, value)?;
                self.tables.push(key.path);
            }
            Kind::Tables(entries) => self.entries(key, value, entries)?,
            Kind::Choice(choices, ..) => self.choose(key, kind::choice(key, value, choices)?),
            kind => kind.read(key, value, &mut self.document)?,
        }
        Ok(())
    }

    /// A key that the file does not state.
    fn take_default(&mut self, key: &'static Key<S>) -> Result<(), Fault> {
        match (key.default, &key.kind) {
            (Default::Required(_), _) => return Err(self.missing(key)),
            (Default::Initial(_), _) if self.document.as_ref().identifier.law.fits() => {}
            (Default::Value(number) | Default::Initial(number), kind) => {
                let most = match kind {
                    Kind::Number(Range::BelowNyquist, _) => {
                        PI / self.document.as_ref().stated.sample_time
                    }
                    _ => f64::INFINITY,
                };
                let number = if number < most { number } else { 0.5 * most };
                kind.set_number(number, &mut self.document);
            }
            (_, Kind::Choice(..)) => self.choose(key, 0),
            (_, Kind::Table(when))
                if self
                    .document
                    .holds(*when, &|table| self.source.value(table).is_some()) =>
            {
                self.tables.push(key.path)
            }
            _ => {}
        }
        Ok(())
    }

    fn choose(&mut self, key: &'static Key<S>, index: usize) {
        if let Kind::Choice(choices, set, _) = &key.kind {
            set(&mut self.document, index);
            self.choices.push((key.place().0, &choices[index], choices));
        }
    }

    /// Tables of which there may be many, one after the other.
    fn entries(
        &mut self,
        key: &'static Key<S>,
        value: &'b Value<'a>,
        entries: &Entries<S>,
    ) -> Result<(), Fault> {
        if let DeValue::Table(_) = value.get_ref() {
            return Err(kind::other(key, value, "a list of tables")
                .advising(format!("write {}, in double brackets", key.heading())));
        }
        for entry in kind::list(key, value, entries.max)? {
            let DeValue::Table(table) = entry.get_ref() else {
                return Err(kind::other(key, entry, "a table"));
            };
            (entries.begin)(&mut self.document);
            self.tables.push(key.path);
            self.entry = Some((key.path, table));
            for key in Key::<S>::children(key.path) {
                self.read(key)
                    .map_err(|fault| fault.or_at(entry.span().start))?;
            }
            (entries.check)(&self.document).map_err(|error| {
                let stated = table.get(error.parameter).unwrap_or(entry);
                let key = format!("{}.{}", key.path, error.parameter);
                Fault::new(key, error).at(stated.span().start)
            })?;
            self.entry = None;
            self.tables.retain(|&path| path != key.path);
            self.choices.retain(|(path, ..)| *path != key.path);
        }
        Ok(())
    }

    /// The fault of a required key that is missing, with all those beside it that are missing too.
    fn missing(&self, key: &'static Key<S>) -> Fault {
        let (table, name) = key.place();
        let mut made = self.choices.iter();
        let owner =
            made.find(|(within, choice, _)| *within == table && choice.takes.contains(&name));
        let needed = match owner {
            Some((_, choice, _)) => format!("\"{}\"", choice.name),
            None => Key::<S>::at(table).map_or(String::new(), Key::heading),
        };
        let beside = Key::<S>::children(table)
            .filter(|other| self.value(other).is_none())
            .filter(|other| self.refusing(other).is_none());
        let fault = format!("this value is missing: {needed} needs it");
        Fault::new(key.path, fault).advising(examples(beside))
    }
}

/// Refuses the first key of a table, in the order of the file, that no line of [`KEYS`] has.
fn refuse_unknown<S: Document>(table: &DeTable<'_>, path: &str) -> Result<(), Fault> {
    let inside = |name: &str| match path {
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    };
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    for (name, value) in entries {
        let full = inside(name.get_ref());
        match (Key::<S>::at(&full), value.get_ref()) {
            (Some(_), DeValue::Table(inner)) => refuse_unknown::<S>(inner, &full)?,
            (Some(key), DeValue::Array(list)) if matches!(key.kind, Kind::Tables(_)) => {
                for inner in list.iter().filter_map(|entry| entry.get_ref().as_table()) {
                    refuse_unknown::<S>(inner, &full)?;
                }
            }
            (Some(_), _) => {}
            (None, _) => {
                let fault = "there is no such key";
                return Err(Fault::new(inside(&shown(name.get_ref())), fault)
                    .at(name.span().start)
                    .advising(advice::<S>(path, name.get_ref())));
            }
        }
    }
    Ok(())
}

/// The nearest key to an unknown one, and the keys of its table.
fn advice<S: Document>(table: &str, unknown: &str) -> String {
    let names: Vec<_> = Key::<S>::children(table).map(|key| key.place().1).collect();
    let near = nearest(unknown, names.iter().copied());
    let meant = near.or_else(|| Key::<S>::nearest(unknown).map(|key| key.path));
    let mut lines = meant.map_or(String::new(), |meant| format!("did you mean {meant}?\n"));
    if !names.is_empty() {
        lines += &format!("allowed: the keys {}\n", names.join(", "));
        let keys = format!("servo-id keys {table}");
        lines += &format!("`{}` explains them", keys.trim_end());
    }
    lines
}

/// The fault of a key that has no meaning beside a choice. If it were accepted, the user would rely on a setting
/// without effect.
fn key_not_applicable<S: Document>(key: &Key<S>, choice: &Choice) -> Fault {
    let takes = match choice.takes {
        [] => "nor any other of its kind".to_owned(),
        takes => format!("but {}", takes.join(", ")),
    };
    Fault::new(
        key.path,
        format!("\"{}\" does not take this key, {takes}", choice.name),
    )
}

fn check_table<S: Document>(key: &Key<S>, value: &Value<'_>) -> Result<(), Fault> {
    match value.get_ref() {
        DeValue::Table(_) => Ok(()),
        DeValue::Array(_) => Err(kind::other(key, value, "one table")
            .advising(format!("write [{}] once, in single brackets", key.path))),
        _ => Err(kind::other(key, value, "a table")),
    }
}

#[cfg(test)]
mod tests {
    use crate::scenario::Options;

    #[test]
    fn the_usual_cut_off_suits_a_slow_loop() {
        for (sample_time, cutoff) in [(1e-3, 500.0), (6e-3, 500.0), (8e-3, 196.35)] {
            let text = format!(
                "[encoder]\ncounts_per_rev = 1771\n[controller]\nsample_time = {sample_time}\n[identifier]\nlaw = \"fit\"\n\
                 [log]\ntime = \"t\"\nposition = \"q\"\ncommand = \"u\"\n"
            );
            let read = Options::parse("slow.toml", &text).expect("a scenario");
            assert!((read.stated.cutoff - cutoff).abs() < 0.01, "{sample_time}");
        }
    }
}
