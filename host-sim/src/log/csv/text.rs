//! The text of a log as lines of fields: unpacked, within bounds, without its comments.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::rc::Rc;

use flate2::read::MultiGzDecoder;

use super::super::LogError;
use crate::nearest;

/// The longest row, bytes, whatever a file unpacks to.
const MAX_ROW: usize = 1 << 20;

/// The bytes of a log, without comments.
pub(super) type Text = Uncommented<Bounded<Box<dyn Read>>>;

/// Bytes that a file may still give before the next row ends.
#[derive(Debug, Clone)]
pub(super) struct Allowance(Rc<Cell<usize>>);

impl Allowance {
    /// A row has ended.
    pub(super) fn renew(&self) {
        self.0.set(MAX_ROW);
    }
}

/// Opens a `.csv` or `.csv.gz` file.
///
/// # Errors
/// The file that cannot be read, or is none.
pub(super) fn open(path: &Path) -> Result<(Text, Allowance), LogError> {
    let unreadable = |error: io::Error| {
        let why = nearest::unreadable(path, &error);
        LogError::in_file(path, format!("the log cannot be read: {why}"))
    };
    let file = File::open(path).map_err(unreadable)?;
    if !file.metadata().map_err(unreadable)?.is_file() {
        return Err(LogError::in_file(
            path,
            "a log is read more than once, so it must be a file: save what comes through a pipe \
             first"
                .to_owned(),
        ));
    }
    let packed = path.extension().is_some_and(|end| end == "gz");
    let bytes: Box<dyn Read> = if packed {
        Box::new(MultiGzDecoder::new(BufReader::new(file)))
    } else {
        Box::new(file)
    };
    Ok(from_bytes(bytes))
}

fn from_bytes(bytes: Box<dyn Read>) -> (Text, Allowance) {
    let allowance = Allowance(Rc::new(Cell::new(MAX_ROW)));
    let bounded = Bounded {
        inner: bytes,
        allowance: allowance.clone(),
    };
    (Uncommented::new(bounded), allowance)
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
            return Err(io::Error::other(format!(
                "it is longer than {MAX_ROW} bytes: is a quotation mark or a line's end missing?"
            )));
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
    at: At,
    /// True if the last byte was a carriage return, whose line feed is still to come.
    returned: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum At {
    /// Behind this number of bytes of what may be a byte-order mark at the beginning of the text.
    Mark(usize),
    /// At the beginning of a line.
    Line,
    /// Behind a slash that a line begins with.
    Slash,
    Comment,
    Row,
    /// Behind the last line.
    End,
}

impl<R: Read> Uncommented<R> {
    fn new(inner: R) -> Self {
        Self {
            inner,
            at: At::Mark(0),
            returned: false,
        }
    }

    /// Keeps what belongs to rows of the bytes from `first` to `end`, moved to the front; a slash that
    /// was held back is in front of them already. Answers with how many there are.
    fn keep(&mut self, bytes: &mut [u8], first: usize, end: usize) -> usize {
        const MARK: [u8; 3] = [0xef, 0xbb, 0xbf];
        let (mut from, mut to) = (first, 0);
        while from < end {
            let byte = bytes[from];
            let after_return = std::mem::take(&mut self.returned);
            match (self.at, byte) {
                (At::Mark(seen), byte) if MARK.get(seen) == Some(&byte) => {
                    self.at = At::Mark(seen + 1);
                    from += 1;
                }
                (At::Mark(_), _) => self.at = At::Line,
                (At::Line, b'\n') if after_return => from += 1,
                (At::Line, b' ') => from += 1,
                (At::Line, b'#' | b'%') | (At::Slash, b'/') => self.at = At::Comment,
                (At::Line, b'/') => {
                    self.at = At::Slash;
                    from += 1;
                }
                (At::Slash, _) => {
                    bytes[to] = b'/';
                    to += 1;
                    self.at = At::Row;
                }
                _ => {
                    let rest = &bytes[from..end];
                    let stop = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
                    if self.at != At::Comment {
                        self.at = At::Row;
                        bytes.copy_within(from..from + stop, to);
                        to += stop;
                    }
                    from += stop;
                    if from < end {
                        self.returned = bytes[from] == b'\r';
                        bytes[to] = b'\n';
                        to += 1;
                        from += 1;
                        self.at = At::Line;
                    }
                }
            }
        }
        to
    }
}

impl<R: Read> Read for Uncommented<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        /// Room for a slash that was held back.
        const HELD: usize = 1;
        if buffer.len() <= HELD || self.at == At::End {
            return Ok(0);
        }
        loop {
            let read = self.inner.read(&mut buffer[HELD..])?;
            if read == 0 {
                let unended = self.at == At::Row;
                self.at = At::End;
                buffer[0] = b'\n';
                return Ok(usize::from(unended));
            }
            let kept = self.keep(buffer, HELD, HELD + read);
            if kept > 0 {
                return Ok(kept);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A text as it is read in pieces of at most `piece` bytes.
    fn read(text: &[u8], piece: usize) -> String {
        let (mut reader, _) = from_bytes(Box::new(io::Cursor::new(text.to_vec())));
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
}
