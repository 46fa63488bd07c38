//! The text of a log as lines of fields: unpacked, within bounds, without its comments.

use std::cell::Cell;
use std::cmp::Ordering;
use std::io::{self, BufRead, BufReader, Read};
use std::rc::Rc;

use super::dialect::Dialect;
use super::line::{bare, squeezed, uncommented};

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

/// The text of some bytes, as its dialect has it.
pub(super) fn from_bytes(bytes: Box<dyn Read>, dialect: Dialect) -> (Text, Allowance) {
    let allowance = Allowance(Rc::new(Cell::new(MAX_ROW)));
    let bounded = Bounded {
        inner: bytes,
        allowance: allowance.clone(),
    };
    let text = Uncommented {
        inner: BufReader::new(bounded),
        line: Vec::new(),
        given: 0,
        number: 0,
        dialect,
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

/// Reads a text without the lines above its table, comments, byte-order mark and spaces at the beginning of lines.
/// Every line ends with a line feed alone, the last one too, and a comment leaves its empty line. The lines are thus
/// counted as in an editor.
#[derive(Debug)]
pub(super) struct Uncommented<R> {
    inner: R,
    /// The present line, and the bytes of it that were read.
    line: Vec<u8>,
    given: usize,
    /// Its number, from 1.
    number: u64,
    dialect: Dialect,
}

impl<R: BufRead> Uncommented<R> {
    /// Takes the next line; false at the end.
    fn advance(&mut self) -> io::Result<bool> {
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
        self.number += 1;
        let text = uncommented(&self.line);
        let is_left_out = match self.number.cmp(&self.dialect.heading) {
            Ordering::Less => true,
            // The names of the columns may stand in a comment.
            Ordering::Equal => false,
            Ordering::Greater => is_comment(&self.line),
        };
        if is_left_out {
            self.line.clear();
        } else if self.dialect.is_by_spaces() {
            self.line = squeezed(bare(text, b' '));
        } else {
            let text = bare(text, self.dialect.separator);
            let from = text.as_ptr() as usize - self.line.as_ptr() as usize;
            let end = from + text.len();
            self.line.truncate(end);
            self.given = from;
        }
        self.line.push(b'\n');
        Ok(true)
    }
}

fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.starts_with(b"#") || line.starts_with(b"%") || line.starts_with(b"//")
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

    const fn commas(heading: u64) -> Dialect {
        Dialect {
            separator: b',',
            heading,
        }
    }

    /// Reads a text in pieces of at most `piece` bytes. Its table begins with a line.
    fn read(text: &[u8], heading: u64, piece: usize) -> String {
        let bytes = Box::new(io::Cursor::new(text.to_vec()));
        let (mut reader, _) = from_bytes(bytes, commas(heading));
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
            assert_eq!(read(text.as_bytes(), 3, piece), rows, "{piece}");
            assert_eq!(read(rows.as_bytes(), 3, piece), rows, "{piece}");
        }
        assert_eq!(read(b"a\rb\r\rc", 1, 4), "a\nb\n\nc\n");
        assert_eq!(read(b"", 1, 4), "");
    }

    #[test]
    fn the_end_stays_the_end() {
        let (mut reader, _) = from_bytes(Box::new(io::Cursor::new(b"1,2".to_vec())), commas(1));
        let mut all = Vec::new();
        reader.read_to_end(&mut all).expect("within bounds");
        // A reader of columns asks again behind a quotation mark that is not closed.
        assert_eq!(reader.read(&mut [0; 4]).expect("the end"), 0);
    }
}
