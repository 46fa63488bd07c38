//! The text of a log as lines of fields: unpacked, within bounds, without its comments.

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::rc::Rc;

use super::super::{LogError, source};

/// The longest row, bytes, whatever a file unpacks to.
const MAX_ROW: usize = 1 << 20;

/// The bytes of a log, without comments.
pub(super) type Text = Uncommented<BufReader<Bounded<Box<dyn Read>>>>;

/// Bytes that a file may still give before the next row ends.
#[derive(Debug, Clone)]
pub(super) struct Allowance(Rc<Cell<usize>>);

impl Allowance {
    /// A row has ended.
    pub(super) fn renew(&self) {
        self.0.set(MAX_ROW);
    }
}

/// Opens a `.csv` or `.csv.gz` file, runs of spaces as one where they divide its columns.
///
/// # Errors
/// The file that cannot be read, or is none.
pub(super) fn open(path: &Path, by_spaces: bool) -> Result<(Text, Allowance), LogError> {
    let bytes = source::open(path)?;
    Ok(from_bytes(bytes, by_spaces))
}

fn from_bytes(bytes: Box<dyn Read>, by_spaces: bool) -> (Text, Allowance) {
    let allowance = Allowance(Rc::new(Cell::new(MAX_ROW)));
    let bounded = Bounded {
        inner: bytes,
        allowance: allowance.clone(),
    };
    let text = Uncommented {
        inner: BufReader::new(bounded),
        line: Vec::new(),
        given: 0,
        is_first: true,
        by_spaces,
    };
    (text, allowance)
}

/// Reads until the allowance is used up: no row fills the memory, whatever a few packed bytes unpack to.
#[derive(Debug)]
pub(super) struct Bounded<R> {
    inner: R,
    allowance: Allowance,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let allowed = self.allowance.0.get();
        if allowed == 0 {
            let fault = format!(
                "it is longer than {MAX_ROW} bytes: is a quotation mark or a line's end missing?"
            );
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, fault));
        }
        let most = buffer.len().min(allowed);
        let read = self.inner.read(&mut buffer[..most])?;
        self.allowance.0.set(allowed - read);
        Ok(read)
    }
}

/// Reads a text without its comments, byte-order mark and spaces at the beginning of lines. Every line
/// ends with a line feed alone, the last one too, and a comment leaves its empty line: the lines are
/// still counted as an editor counts them.
///
/// A line is a comment that begins with `#`, `%` or `//`.
#[derive(Debug)]
pub(super) struct Uncommented<R> {
    inner: R,
    /// The present line, and the bytes of it that were read.
    line: Vec<u8>,
    given: usize,
    is_first: bool,
    /// Runs of spaces and tabs divide columns.
    by_spaces: bool,
}

impl<R: BufRead> Uncommented<R> {
    /// Takes the next line; false at the end.
    fn advance(&mut self) -> io::Result<bool> {
        const MARK: &[u8] = b"\xef\xbb\xbf";
        self.line.clear();
        self.given = 0;
        let end = loop {
            let bytes = self.inner.fill_buf()?;
            let end = memchr::memchr2(b'\n', b'\r', bytes);
            let length = end.unwrap_or(bytes.len());
            self.line.extend_from_slice(&bytes[..length]);
            let ending = end.map(|end| bytes[end]);
            self.inner.consume(length + usize::from(ending.is_some()));
            if ending.is_some() || length == 0 {
                break ending;
            }
        };
        if end.is_none() && self.line.is_empty() {
            return Ok(false);
        }
        // A line feed behind a carriage return is of the same ending.
        if end == Some(b'\r') && self.inner.fill_buf()?.first() == Some(&b'\n') {
            self.inner.consume(1);
        }
        let is_first = std::mem::take(&mut self.is_first);
        let mark = if is_first && self.line.starts_with(MARK) {
            MARK.len()
        } else {
            0
        };
        let spaces = self.line[mark..]
            .iter()
            .take_while(|&&byte| byte == b' ')
            .count();
        self.given = mark + spaces;
        let text = &self.line[self.given..];
        if text.starts_with(b"#") || text.starts_with(b"%") || text.starts_with(b"//") {
            self.given = self.line.len();
        }
        if self.by_spaces {
            self.line = squeezed(&self.line[self.given..]);
            self.given = 0;
        }
        self.line.push(b'\n');
        Ok(true)
    }
}

/// A line with one space for every run of spaces and tabs, and none at its ends; within quotation marks it is as it was.
pub(super) fn squeezed(line: &[u8]) -> Vec<u8> {
    let mut squeezed = Vec::with_capacity(line.len());
    let mut quoted = false;
    for &byte in line.trim_ascii() {
        quoted ^= byte == b'"';
        let is_space = !quoted && (byte == b' ' || byte == b'\t');
        match is_space {
            true if squeezed.last() == Some(&b' ') => {}
            true => squeezed.push(b' '),
            false => squeezed.push(byte),
        }
    }
    squeezed
}

impl<R: BufRead> Read for Uncommented<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given == self.line.len() && !self.advance()? {
            return Ok(0);
        }
        let read = (&self.line[self.given..]).read(buffer)?;
        self.given += read;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A text as it is read in pieces of at most `piece` bytes.
    fn read(text: &[u8], piece: usize) -> String {
        let (mut reader, _) = from_bytes(Box::new(io::Cursor::new(text.to_vec())), false);
        let mut buffer = vec![0; piece];
        let mut all = Vec::new();
        loop {
            match reader.read(&mut buffer).expect("within bounds") {
                0 => return String::from_utf8(all).expect("text"),
                read => all.extend_from_slice(&buffer[..read]),
            }
        }
    }

    #[test]
    fn comments_marks_and_returns_go_and_lines_stay() {
        let text =
            "\u{feff}# drive 7, \"run\r\n% gains\r\nt,q\r\n  // units\n1,2\n/ros/q,3\n\n#\n4,5";
        for piece in [2, 3, 5, 64, 4096] {
            let rows = "\n\nt,q\n\n1,2\n/ros/q,3\n\n\n4,5\n";
            assert_eq!(read(text.as_bytes(), piece), rows, "{piece}");
            assert_eq!(read(rows.as_bytes(), piece), rows, "{piece}");
        }
        assert_eq!(read(b"a\rb\r\rc", 4), "a\nb\n\nc\n");
        assert_eq!(read(b"", 4), "");
    }

    #[test]
    fn the_end_stays_the_end() {
        let (mut reader, _) = from_bytes(Box::new(io::Cursor::new(b"1,2".to_vec())), false);
        let mut all = Vec::new();
        reader.read_to_end(&mut all).expect("within bounds");
        // A reader of columns asks again behind a quotation mark that is not closed.
        assert_eq!(reader.read(&mut [0; 4]).expect("the end"), 0);
    }
}
