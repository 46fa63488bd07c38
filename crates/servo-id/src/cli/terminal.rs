//! The width of the terminal, and text that fits it.

use std::borrow::Cow;
use std::io::{self, IsTerminal, Write as _};

use terminal_size::{Width, terminal_size_of};
use textwrap::core::display_width;
use textwrap::{Options, WordSeparator, WordSplitter, WrapAlgorithm};

/// Narrowest width of a table.
const MIN_WIDTH: u16 = 20;

/// Characters to a line: COLUMNS, or the terminal's width; as many as there are in a file or a pipe.
pub(super) fn width() -> u16 {
    stated_width()
        .or_else(|| terminal_size_of(io::stdout()).map(|(Width(width), _)| width))
        .filter(is_wide_enough)
        .unwrap_or(u16::MAX)
}

fn stated_width() -> Option<u16> {
    let stated = std::env::var("COLUMNS").ok();
    let stated = stated.and_then(|columns| columns.trim().parse().ok());
    stated.filter(is_wide_enough)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "a filter passes so")]
fn is_wide_enough(width: &u16) -> bool {
    *width >= MIN_WIDTH
}

/// A text for standard output. On a terminal, or with COLUMNS, sentences are wrapped at spaces. In a file or a pipe a
/// sentence is one line.
pub(super) fn folded(text: &str) -> String {
    match io::stdout().is_terminal() || stated_width().is_some() {
        true => within(text, usize::from(width())),
        false => text.to_owned(),
    }
}

/// A text for standard error, as [`folded`].
pub(super) fn folded_error(text: &str) -> String {
    let terminal = || terminal_size_of(io::stderr()).map(|(Width(width), _)| width);
    match stated_width().or_else(terminal).filter(is_wide_enough) {
        Some(width) => within(text, usize::from(width)),
        None => text.to_owned(),
    }
}

/// Prints a line on standard error, folded; nothing depends on it, even where standard error is closed.
pub(super) fn notify(line: &str) {
    let _ = writeln!(anstream::stderr(), "{}", folded_error(line));
}

/// A text whose lines have at most `width` characters, but for longer words; colours take no place. A line is continued two
/// characters further to the right than it begins.
fn within(text: &str, width: usize) -> String {
    let lines = text.split('\n').map(|line| {
        if display_width(line) <= width {
            return Cow::Borrowed(line);
        }
        let begins = line.len() - line.trim_start_matches(' ').len();
        let indent = " ".repeat(begins + 2);
        let options = Options::new(width)
            .subsequent_indent(&indent)
            .break_words(false)
            .word_separator(WordSeparator::AsciiSpace)
            .word_splitter(WordSplitter::NoHyphenation)
            .wrap_algorithm(WrapAlgorithm::FirstFit);
        Cow::Owned(textwrap::fill(line, options))
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn sentences_are_divided_at_spaces_and_colours_take_no_place() {
        let text = "  one two three four\n\u{1b}[1mfive\u{1b}[0m six\nseventyseven eight";
        let folded =
            "  one two\n    three\n    four\n\u{1b}[1mfive\u{1b}[0m six\nseventyseven\n  eight";
        assert_eq!(within(text, 10), folded);
        assert_eq!(within(text, 100), text);
    }
}
