//! The dialect of a text, detected from its beginning.

use std::path::Path;

use super::super::{LogError, other};
use super::cell::is_value;
use super::line::{bare, squeezed, uncommented};

/// The dialect of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) struct Dialect {
    /// The byte between two columns.
    pub(super) separator: u8,
    /// The first line of the table, its heading or its numbers, from 1. The text above is a preamble.
    pub(super) heading: u64,
}

impl Dialect {
    /// The bytes that may separate two columns, the likelier one first.
    const SEPARATORS: [u8; 4] = [b';', b'\t', b',', b' '];

    /// Bytes that are examined.
    pub(super) const EXAMINED: u64 = 1 << 16;

    /// Detects it from the beginning of a text.
    ///
    /// # Errors
    /// The file that is no text of a kind that is known.
    pub(super) fn detect(path: &Path, beginning: &[u8]) -> Result<Self, LogError> {
        if beginning.starts_with(&[0xff, 0xfe]) || beginning.starts_with(&[0xfe, 0xff]) {
            let fault = "this is text in UTF-16: save the log in UTF-8".to_owned();
            return Err(LogError::in_file(path, fault));
        }
        if let Some(place) = memchr::memchr(0, beginning) {
            let fault = other::fault(path, beginning).unwrap_or_else(|| {
                format!(
                    "this is not text (byte {} is zero): save the log as comma-separated text in UTF-8",
                    place + 1
                )
            });
            return Err(LogError::in_file(path, fault));
        }
        if beginning.starts_with(b"PK\x03\x04") || beginning.starts_with(&[0x1f, 0x8b]) {
            let fault = "this is a packed file or a workbook: save the log as comma-separated text, .csv or .csv.gz";
            return Err(LogError::in_file(path, fault.to_owned()));
        }
        match other::of_text(path, beginning) {
            Some(fault) => Err(LogError::in_file(path, fault)),
            None => Ok(Self::in_text(beginning)),
        }
    }

    /// True for columns that any number of spaces divides.
    pub(super) fn is_by_spaces(self) -> bool {
        self.separator == b' '
    }

    /// The separator that divides the most lines alike into the most cells with numbers, and the first of the lines of
    /// one width.
    fn in_text(beginning: &[u8]) -> Self {
        /// Lines that are examined.
        const LINES: usize = 400;
        let mut lines: Vec<(Vec<u8>, u64)> = Vec::new();
        let all = beginning.split(|&byte| byte == b'\n').map(uncommented);
        for (line, number) in all.zip(1..).filter(|(line, _)| !line.is_empty()) {
            let count = lines.len();
            match lines.last_mut().filter(|(last, _)| is_within_list(last)) {
                Some((last, _)) => last.extend([b" ", line].concat()),
                None if count == LINES => break,
                None => lines.push((line.to_vec(), number)),
            }
        }
        // Where the beginning ends may be in the middle of a row.
        if lines.len() > 2 && beginning.len() as u64 >= Self::EXAMINED {
            lines.pop();
        }
        let found = Self::SEPARATORS.map(|separator| {
            let cells: Vec<_> = lines
                .iter()
                .map(|(line, _)| Cells::of(line, separator))
                .collect();
            let mut best = (0, 0);
            let mut first = 0;
            for at in 0..cells.len() {
                if !cells[at].is_as_wide_as(cells[first]) {
                    first = at;
                }
                let numbers = cells[first..=at]
                    .iter()
                    .map(|one| one.numbers)
                    .sum::<usize>();
                if numbers > best.0 && cells[at].all > 1 {
                    best = (numbers, first);
                }
            }
            // A row of another width within the table leaves its heading where it is.
            let wide = |one: &&Cells| one.is_as_wide_as(cells[best.1]);
            let is_words = |one: &Cells| wide(&one) && one.numbers == 0;
            let heading = cells.iter().position(is_words);
            best.1 = heading
                .filter(|heading| *heading < best.1)
                .unwrap_or(best.1);
            // Nor does a heading with a name more or fewer than the rows have cells end the table.
            if let Some(above) = best.1.checked_sub(1)
                && cells[above].is_heading_of(cells[best.1])
            {
                best.1 = above;
            }
            (separator, best)
        });
        let most = found.iter().map(|(_, (numbers, _))| *numbers).max();
        let best = found
            .iter()
            .find(|(_, (numbers, _))| Some(*numbers) == most);
        let numbers = best.map_or(0, |(_, (numbers, _))| *numbers);
        let Some((separator, (_, first))) = best.filter(|_| numbers > 0) else {
            return Self::without_numbers(&lines);
        };
        Self {
            separator: *separator,
            heading: lines.get(*first).map_or(1, |(_, number)| *number),
        }
    }

    /// The separator that divides the first line most, for a text without a number.
    fn without_numbers(lines: &[(Vec<u8>, u64)]) -> Self {
        let first = lines.first().map_or(&[][..], |(line, _)| line);
        let named = [b';', b'\t', b','];
        let most = |separator: &u8| Cells::of(first, *separator).all;
        Self {
            separator: named.into_iter().max_by_key(most).unwrap_or(b','),
            heading: 1,
        }
    }

    /// The separator's name.
    pub(super) fn separator_name(self) -> &'static str {
        name_of(self.separator)
    }

    /// The separators that a row has besides the dialect's own, by name.
    pub(super) fn others(self, row: &[u8]) -> Option<&'static str> {
        let found = |separator: &&u8| **separator != self.separator && row.contains(separator);
        Self::SEPARATORS[..3]
            .iter()
            .find(found)
            .copied()
            .map(name_of)
    }
}

/// True for a line that ends within a list in quotation marks, which goes on in the next, as numpy writes one of many numbers.
fn is_within_list(line: &[u8]) -> bool {
    let mut pieces = line.rsplit(|&byte| byte == b'"');
    let begins = |piece: &[u8]| piece.starts_with(b"[") || piece.starts_with(b"(");
    pieces.next().is_some_and(begins) && pieces.count() % 2 == 1
}

fn name_of(separator: u8) -> &'static str {
    match separator {
        b';' => "semicolon",
        b'\t' => "tab",
        b' ' => "space",
        _ => "comma",
    }
}

/// The cells of a line.
#[derive(Clone, Copy)]
struct Cells {
    all: usize,
    numbers: usize,
    ends_empty: bool,
}

impl Cells {
    fn of(line: &[u8], separator: u8) -> Self {
        let squeezed;
        let line = match separator {
            b' ' => {
                squeezed = self::squeezed(bare(line, separator));
                &squeezed[..]
            }
            _ => bare(line, separator),
        };
        let mut cells = Self {
            all: 0,
            numbers: 0,
            ends_empty: false,
        };
        let (mut quoted, mut from) = (false, 0);
        for at in 0..=line.len() {
            let byte = line.get(at).copied();
            quoted ^= byte == Some(b'"');
            if byte.is_none() || (!quoted && byte == Some(separator)) {
                let cell = line[from..at].trim_ascii();
                let bare = cell
                    .strip_prefix(b"\"")
                    .and_then(|cell| cell.strip_suffix(b"\""));
                cells.all += 1;
                cells.numbers += usize::from(is_value(bare.unwrap_or(cell)));
                cells.ends_empty = cell.is_empty();
                from = at + 1;
            }
        }
        cells
    }

    /// True for words above numbers, one more or fewer.
    fn is_heading_of(self, row: Self) -> bool {
        let [names, cells] = [self, row].map(|line| line.all - usize::from(line.ends_empty));
        self.numbers == 0 && row.numbers > 0 && names > 1 && names.abs_diff(cells) == 1
    }

    /// True for lines of one table: a row may have an empty cell behind its last.
    fn is_as_wide_as(self, other: Self) -> bool {
        let widths = |cells: Self| [cells.all, cells.all - usize::from(cells.ends_empty)];
        let [most, least] = widths(self);
        widths(other)
            .iter()
            .any(|width| (least..=most).contains(width))
    }
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
            ("t,q,u\n1;2;3\n", b';'),
            ("gain,2\nt;q;u\n1,5;2,5;3,5\n", b';'),
            ("", b','),
            ("t q u\n1  2,5   3\n", b' '),
            ("1,5 2,5 3,5\n2,5 3,5 4,5\n", b' '),
            ("time s, angle deg\n1, 2\n", b','),
            ("t,q\n2026-11-22 06:25:00,1\n", b','),
            ("t;q\n2026-11-22 06:25:00,5;1,5\n", b';'),
        ] {
            let found = Dialect::in_text(text.as_bytes());
            assert_eq!(found.separator, separator, "{text}");
        }
    }
}
