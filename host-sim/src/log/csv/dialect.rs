//! The dialect of a text, detected from its beginning.

use std::io::{ErrorKind, Read};
use std::path::Path;

use super::super::LogError;
use super::text;

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
        let (text, _) = text::open(path)?;
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
        Ok(Self::in_text(&beginning))
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
        Self {
            separator: alike.or_else(likeliest).unwrap_or(b','),
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
        _ => "comma",
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
        ] {
            assert_eq!(
                Dialect::in_text(text.as_bytes()).separator,
                separator,
                "{text}"
            );
        }
    }
}
