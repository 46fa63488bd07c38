//! The dialect of a text, detected from its beginning.

use std::io::{ErrorKind, Read};
use std::path::Path;

use super::super::LogError;
use super::cell::is_number;
use super::{stamp, text};
use crate::gone;

/// The dialect of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) struct Dialect {
    /// The byte between two columns.
    pub(super) separator: u8,
}

impl Dialect {
    /// The bytes that may stand between two columns, the likeliest first where two would do.
    const SEPARATORS: [u8; 3] = [b';', b'\t', b','];

    /// Detects it from the beginning of a file.
    ///
    /// # Errors
    /// The file that cannot be read, or is no text of a kind that is known.
    pub(in super::super) fn detect(path: &Path) -> Result<Self, LogError> {
        /// Bytes that are examined.
        const MAX_EXAMINED: u64 = 1 << 16;
        let (text, _) = text::open(path, false)?;
        let mut beginning = Vec::new();
        let read = text.take(MAX_EXAMINED).read_to_end(&mut beginning);
        // A row that is too long is refused at its line when the rows are read.
        if let Err(error) = read
            && error.kind() != ErrorKind::FileTooLarge
        {
            let fault = format!("the log cannot be read: {error}");
            return Err(LogError::in_file(path, fault));
        }
        if beginning.starts_with(&[0xff, 0xfe]) || beginning.starts_with(&[0xfe, 0xff]) {
            let fault = "this is text in UTF-16: save the log in UTF-8".to_owned();
            return Err(LogError::in_file(path, fault));
        }
        if let Some(instead) = gone::file(&beginning) {
            return Err(LogError::in_file(path, instead.to_owned()));
        }
        if let Some(place) = memchr::memchr(0, &beginning) {
            let fault = format!(
                "this is no text (byte {} is zero): save the log as comma-separated text in UTF-8",
                place + 1
            );
            return Err(LogError::in_file(path, fault));
        }
        if beginning.starts_with(b"PK\x03\x04") || beginning.starts_with(&[0x1f, 0x8b]) {
            let fault = "this is a packed file or a workbook: save the log as comma-separated text, .csv or .csv.gz";
            return Err(LogError::in_file(path, fault.to_owned()));
        }
        Ok(Self::in_text(&beginning))
    }

    /// True for columns that any number of spaces divides.
    pub(super) fn is_by_spaces(self) -> bool {
        self.separator == b' '
    }

    /// The first separator that divides the heading and every examined row alike; otherwise the one
    /// that the heading has most of.
    fn in_text(beginning: &[u8]) -> Self {
        /// Rows that are examined.
        const ROWS: usize = 20;
        let mut rows: Vec<_> = beginning
            .split(|&byte| byte == b'\n')
            .filter(|line| !line.trim_ascii().is_empty())
            .take(ROWS)
            .collect();
        // Where the beginning ends may be in the middle of a row.
        if rows.len() > 1 && !beginning.ends_with(b"\n") {
            rows.pop();
        }
        let count = |row: &&[u8], separator| outside_quotes(row, separator);
        let divides = |separator: &u8| {
            let mut counts = rows.iter().map(|row| count(row, *separator));
            let heading = counts.next().unwrap_or(0);
            heading > 0 && counts.all(|count| count == heading)
        };
        let most = |separator: &u8| rows.first().map_or(0, |row| count(row, *separator));
        let alike = Self::SEPARATORS.into_iter().find(divides);
        let likeliest = || Self::SEPARATORS.into_iter().max_by_key(most);
        let separator = alike.or_else(likeliest).unwrap_or(b',');
        // Spaces also stand in headings, beside separators and in time stamps: they divide where they make numbers.
        let last = rows.last().copied().unwrap_or_default();
        let squeezed = text::squeezed(last);
        let by_spaces = share_of_numbers(&squeezed, b' ') > share_of_numbers(last, separator)
            && (alike.is_none() || squeezed.contains(&b' '));
        Self {
            separator: if by_spaces { b' ' } else { separator },
        }
    }

    /// The separator's name.
    pub(in super::super) fn separator_name(self) -> &'static str {
        name_of(self.separator)
    }

    /// The separators that a row has besides the dialect's own, by name.
    pub(super) fn others(self, row: &[u8]) -> Option<&'static str> {
        let found = |separator: &u8| *separator != self.separator && row.contains(separator);
        Self::SEPARATORS.into_iter().find(found).map(name_of)
    }
}

fn name_of(separator: u8) -> &'static str {
    match separator {
        b';' => "semicolon",
        b'\t' => "tab",
        b' ' => "space",
        _ => "comma",
    }
}

/// The share of the cells of a row that are numbers, where there are two or more.
fn share_of_numbers(row: &[u8], separator: u8) -> f64 {
    let cells: Vec<_> = row.split(|&byte| byte == separator).collect();
    let numbers = cells.iter().filter(|cell| {
        let cell = cell.trim_ascii();
        let unquoted = cell
            .strip_prefix(b"\"")
            .and_then(|cell| cell.strip_suffix(b"\""));
        let cell = unquoted.unwrap_or(cell);
        is_number(cell) || stamp::seconds(cell).is_some()
    });
    match cells.len() {
        0 | 1 => 0.0,
        count => numbers.count() as f64 / count as f64,
    }
}

fn outside_quotes(row: &[u8], separator: u8) -> usize {
    let mut quoted = false;
    let separates = |&&byte: &&u8| {
        quoted ^= byte == b'"';
        !quoted && byte == separator
    };
    row.iter().filter(separates).count()
}

#[cfg(test)]
mod tests {
    use super::Dialect;

    #[test]
    fn separators_are_found_whatever_the_names_contain() {
        for (text, separator) in [
            ("t,q,u\n1,2,3\n", b','),
            ("t;q;u\n1,0;2,5;3,0\n", b';'),
            ("t\tq\tu\n1,0\t2,5\t3,0\n", b'\t'),
            ("\"t, s\";\"q, rad\"\n1;2\n", b';'),
            ("t;s,q;rad\n1,2\n3,4\n", b','),
            ("\"t;s\",\"q;rad\"\n\"1,5\",\"2,5\"\n", b','),
            ("t,q,u", b','),
            ("\n\nt;q\n\n1;2\n", b';'),
            ("t,q,u\n1;2;3\n", b','),
            ("", b','),
            ("t q u\n1  2,5   3\n", b' '),
            ("1,5 2,5 3,5\n2,5 3,5 4,5\n", b' '),
            ("time s, angle deg\n1, 2\n", b','),
            ("t,q\n2026-11-22 06:25:00,1\n", b','),
            ("t;q\n2026-11-22 06:25:00,5;1,5\n", b';'),
        ] {
            assert_eq!(
                Dialect::in_text(text.as_bytes()).separator,
                separator,
                "{text}"
            );
        }
    }
}
