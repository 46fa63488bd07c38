//! Suggestions for a misspelt name: the nearest known one.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The name that is most like a word, if one is alike.
pub fn name<'n>(word: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    /// The smallest likeness of a suggestion.
    const MIN_LIKENESS: f64 = 0.6;
    let likeness = |name: &str| strsim::normalized_damerau_levenshtein(word, name);
    let best = names.max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
    (likeness(best) >= MIN_LIKENESS).then_some(best)
}

/// A user's text as a message repeats it: shortened, and without control characters.
#[must_use]
pub fn shortened(text: &str, max_characters: usize) -> String {
    let shown = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut short: String = text.chars().map(shown).take(max_characters).collect();
    if text.chars().nth(max_characters).is_some() {
        short.push('…');
    }
    short
}

/// Why a file cannot be read, and which file may have been meant.
#[must_use]
pub fn unreadable(path: &Path, error: &io::Error) -> String {
    let text = error.to_string();
    match error.kind() {
        ErrorKind::NotFound => {
            let near = file(path);
            let hint = near.map(|near| format!("; did you mean {}?", near.display()));
            format!("there is no such file{}", hint.unwrap_or_default())
        }
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        // Without the number that the system has for it.
        _ => text.split(" (os error").next().unwrap_or(&text).to_owned(),
    }
}

/// The file of the same folder whose name is nearest.
fn file(path: &Path) -> Option<PathBuf> {
    let folder = path.parent()?;
    let listed = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let entries = fs::read_dir(listed).ok()?.filter_map(Result::ok);
    let names: Vec<String> = entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    let near = name(
        path.file_name()?.to_str()?,
        names.iter().map(String::as_str),
    )?;
    Some(folder.join(near))
}
