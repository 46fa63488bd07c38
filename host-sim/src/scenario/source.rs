use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::error::{Fault, ScenarioError};
use super::keys;
use super::tables::Tables;

/// The text of a scenario file, to be read and pointed into.
pub(super) struct Source<'a> {
    name: &'a str,
    text: &'a str,
}

impl<'a> Source<'a> {
    pub(super) fn new(name: &'a str, text: &'a str) -> Self {
        Self { name, text }
    }

    /// The tables of the file.
    pub(super) fn tables(&self) -> Result<Tables, ScenarioError> {
        toml::from_str(self.text).map_err(|error| self.explain(&error))
    }

    /// A fault of the contents with its place: the line of its key, or of the nearest table around
    /// it that the file has.
    pub(super) fn locate(&self, fault: Fault) -> ScenarioError {
        ScenarioError {
            file: self.name.to_owned(),
            line: Some(self.line_of_key(&fault.key)),
            allowed: keys::allowed(&fault.key).map(str::to_owned),
            key: Some(fault.key),
            fault: fault.fault,
        }
    }

    /// An error of the parser with the key that it is about.
    fn explain(&self, error: &toml::de::Error) -> ScenarioError {
        let span = error.span().unwrap_or(0..0);
        let message = error.message();
        let enclosing = self.key_at(&span);
        let mut fault = message.lines().collect::<Vec<_>>().join(" ");
        let named = |prefix: &str| {
            let (_, rest) = message.split_once(prefix)?;
            rest.split('`').next()
        };
        let (key, allowed) = if let Some(unknown) = named("unknown field `") {
            let table = match enclosing.as_deref() {
                Some(path) if path == unknown => "",
                Some(path) => path
                    .strip_suffix(unknown)
                    .map_or(path, |table| table.trim_end_matches('.')),
                None => "",
            };
            let known = format!("the keys {}", keys::children(table).join(", "));
            let key = join(table, unknown);
            if let Some(remedy) = keys::remedy(&key) {
                remedy.clone_into(&mut fault);
            }
            (Some(key), Some(known))
        } else if let Some(missing) = named("missing field `") {
            let inside = join(enclosing.as_deref().unwrap_or(""), missing);
            // The span of the whole file covers its first table too.
            let key = match keys::allowed(&inside) {
                Some(_) => inside,
                None => missing.to_owned(),
            };
            let allowed = keys::allowed(&key).map(str::to_owned);
            (Some(key), allowed)
        } else {
            let allowed = enclosing
                .as_deref()
                .and_then(keys::allowed)
                .map(str::to_owned);
            (enclosing, allowed)
        };
        ScenarioError {
            file: self.name.to_owned(),
            line: Some(self.line_at(span.start)),
            key,
            fault,
            allowed,
        }
    }

    fn line_at(&self, offset: usize) -> usize {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    fn line_of_key(&self, path: &str) -> usize {
        let Ok(root) = DeTable::parse(self.text) else {
            return 1;
        };
        let mut table = root.get_ref();
        let mut offset = 0;
        for name in path.split('.') {
            let Some((key, value)) = table.iter().find(|(key, _)| key.get_ref() == name) else {
                break;
            };
            offset = key.span().start;
            match value.get_ref() {
                DeValue::Table(inner) => table = inner,
                _ => break,
            }
        }
        self.line_at(offset)
    }

    /// The path of the innermost key whose name or value covers a place in the text.
    fn key_at(&self, place: &Range<usize>) -> Option<String> {
        fn search(table: &DeTable<'_>, place: &Range<usize>) -> Option<String> {
            table.iter().find_map(|(key, value)| {
                let name = key.get_ref();
                let inner = match value.get_ref() {
                    DeValue::Table(inner) => search(inner, place),
                    _ => None,
                };
                match inner {
                    Some(path) => Some(format!("{name}.{path}")),
                    None => (covers(&key.span(), place) || covers(&value.span(), place))
                        .then(|| name.to_string()),
                }
            })
        }
        let root = DeTable::parse(self.text).ok()?;
        search(root.get_ref(), place)
    }
}

fn covers(span: &Range<usize>, place: &Range<usize>) -> bool {
    span.start <= place.start && place.end <= span.end && !span.is_empty()
}

fn join(table: &str, name: &str) -> String {
    if table.is_empty() {
        name.to_owned()
    } else {
        format!("{table}.{name}")
    }
}
