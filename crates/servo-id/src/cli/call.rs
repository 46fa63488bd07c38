//! The call of the program, for reports.

use std::path::Path;
use std::{env, iter};

use crate::program;

/// The title of a report: the action and its file.
pub(super) fn title(done: &str, file: &Path) -> String {
    let name = file.file_name().unwrap_or(file.as_os_str());
    format!("{done} {}", name.display())
}

/// The call as it can be repeated in a shell.
pub(super) fn command() -> String {
    let words = env::args_os().skip(1);
    let words = words.map(|word| quoted(&word.to_string_lossy()));
    let words: Vec<String> = iter::once(program::NAME.to_owned()).chain(words).collect();
    words.join(" ")
}

/// A word as a shell takes it for one.
fn quoted(word: &str) -> String {
    let is_plain =
        |character: char| character.is_alphanumeric() || "-_./=,:+@%".contains(character);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_are_quoted_where_a_shell_would_split_them() {
        for (word, shown) in [
            ("a/b-1.toml", "a/b-1.toml"),
            ("two words", "'two words'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
            ("<b>", "'<b>'"),
        ] {
            assert_eq!(quoted(word), shown);
        }
    }
}
