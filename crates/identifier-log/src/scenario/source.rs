//! The text of a scenario file: fetched within bounds, taken apart, and pointed into.

use std::io::Read;
use std::ops::Range;
use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::Document;
use super::error::{Fault, ScenarioError, shown};
use super::key::examples;
use super::kind::{Default, Key};
use crate::nearest;

/// The longest scenario, bytes; those of the repository have about a thousand.
const MAX_LENGTH: u64 = 1 << 20;

/// The text of a file.
///
/// # Errors
/// It cannot be read, is no text, or is too long for a scenario.
pub fn fetch(path: &Path) -> Result<String, ScenarioError> {
    let name = path.display().to_string();
    let refused = |line, fault| ScenarioError::new(&name, line, None, fault);
    let unreadable = |error: std::io::Error| {
        let why = nearest::unreadable(path, &error);
        refused(None, format!("the scenario cannot be read: {why}"))
    };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        let fault = "this is a folder: a scenario must be a file";
        return Err(refused(None, fault.to_owned()));
    }
    let mut bytes = Vec::new();
    // One byte more than allowed shows that the file is longer, whatever its kind.
    let within = file.take(MAX_LENGTH + 1).read_to_end(&mut bytes);
    within.map_err(unreadable)?;
    if bytes.len() as u64 > MAX_LENGTH {
        return Err(refused(None, too_long()));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let fault = "this is not text in UTF-8: save the file in that encoding";
        refused(Some(line_after(valid)), fault.to_owned())
    })
}

fn too_long() -> String {
    format!("this file is too long for a scenario: at most {MAX_LENGTH} bytes are allowed")
}

fn line_after(bytes: &[u8]) -> usize {
    1 + bytes.iter().filter(|&&byte| byte == b'\n').count()
}

/// A scenario's text, taken apart.
pub(super) struct Source<'a> {
    name: &'a str,
    text: &'a str,
    pub(super) root: DeTable<'a>,
}

impl<'a> Source<'a> {
    /// Takes a text apart.
    pub(super) fn new(name: &'a str, text: &'a str) -> Result<Self, ScenarioError> {
        let empty = Self {
            name,
            text,
            root: DeTable::new(),
        };
        if text.len() as u64 > MAX_LENGTH {
            return Err(empty.error(1, None, too_long()));
        }
        match DeTable::parse(text) {
            Ok(root) => Ok(Self {
                root: root.into_inner(),
                ..empty
            }),
            Err(error) => Err(empty.explain(&error)),
        }
    }

    /// The value at a path, if the file states one.
    pub(super) fn value(&self, path: &str) -> Option<&toml::Spanned<DeValue<'a>>> {
        let mut names = path.split('.');
        let mut value = self.root.get(names.next()?)?;
        for name in names {
            value = value.get_ref().as_table()?.get(name)?;
        }
        Some(value)
    }

    /// A fault of the contents with its place: the line of its key, or of the nearest table around it in the file.
    pub(super) fn locate<S: Document>(&self, fault: Fault) -> ScenarioError {
        let mut advice = String::new();
        if let Some(key) = Key::<S>::at(&fault.key) {
            advice += &format!("allowed: {}\n", key.allowed());
            if fault.at.is_none() && self.value(&fault.key).is_none() {
                advice += &what_to_write(key);
            }
        }
        let at = fault.at.unwrap_or_else(|| self.offset_of(&fault.key));
        ScenarioError {
            advice: advice + &fault.advice,
            ..self.error(self.line_at(at), Some(fault.key), fault.fault)
        }
    }

    fn error(&self, line: usize, key: Option<String>, fault: String) -> ScenarioError {
        ScenarioError::new(self.name, Some(line), key, fault)
    }

    /// A fault that the parser found, in the user's words.
    fn explain(&self, error: &toml::de::Error) -> ScenarioError {
        let message = error.message();
        if message.contains("recurs") {
            let fault = "tables or lists are nested too deeply for a scenario";
            return self.error(self.deepest(error.span()), None, fault.to_owned());
        }
        let span = error.span().unwrap_or(0..0);
        let line = self.line_at(span.start);
        let piece = self.text.get(span.clone()).unwrap_or_default();
        if message == "duplicate key" {
            let fault = "this is stated twice: remove one of them";
            return self.error(line, Some(shown(piece)), fault.to_owned());
        }
        let before = self.text.get(..span.start).unwrap_or_default();
        let written = before.rsplit('\n').next().unwrap_or_default();
        let rest = self.text.get(span.start..).unwrap_or_default();
        let fault = match message.split_once(", expected ") {
            _ if begins_with_a_point(rest) => {
                "a number begins with a digit: 0.5, not .5".to_owned()
            }
            _ if piece.is_empty() && written.trim_end().ends_with('=') => {
                "a value is missing after =".to_owned()
            }
            Some((_, expected)) if message.starts_with("string values must be quoted") => {
                format!("a text needs quotes, as in kind = \"prbs\" ({expected} expected)")
            }
            Some((wrong, expected)) => format!("this is not TOML: {wrong} ({expected} expected)"),
            None => format!("this is not TOML: {message}"),
        };
        let column = 1 + written.chars().count();
        self.error(line, None, format!("at column {column}: {fault}"))
    }

    /// The line on which nesting is deepest, where the parser gives none.
    fn deepest(&self, span: Option<Range<usize>>) -> usize {
        let dots = |line: &str| line.bytes().filter(|&byte| byte == b'.').count();
        let most = || {
            let lines = self.text.split('\n').enumerate();
            lines
                .max_by_key(|(number, line)| (dots(line), usize::MAX - number))
                .map_or(1, |(number, _)| number + 1)
        };
        span.map_or_else(most, |span| self.line_at(span.start))
    }

    fn line_at(&self, offset: usize) -> usize {
        line_after(&self.text.as_bytes()[..offset.min(self.text.len())])
    }

    fn offset_of(&self, path: &str) -> usize {
        let mut table = &self.root;
        let mut offset = 0;
        for name in path.split('.') {
            let Some((key, value)) = table.get_key_value(name) else {
                break;
            };
            offset = key.span().start;
            match value.get_ref() {
                DeValue::Table(inner) => table = inner,
                _ => break,
            }
        }
        offset
    }
}

/// True for a number without a digit before its point.
fn begins_with_a_point(text: &str) -> bool {
    let number = text.trim_start_matches([' ', '+', '-']);
    let fraction = number.strip_prefix('.');
    fraction.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
}

/// The text to add for a key that a file does not have.
fn what_to_write<S: Document>(key: &Key<S>) -> String {
    match key.default {
        Default::Value(_) | Default::Initial(_) | Default::FirstChoice => {
            format!("not in the file: the default is {}\n", key.default())
        }
        _ => examples(Key::<S>::children(key.path)).replacen(
            '\n',
            &format!("\n  [{}]\n", key.path),
            1,
        ),
    }
}
