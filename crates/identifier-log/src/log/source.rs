//! The bytes of a log.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::fingerprint::Fingerprint;
use super::{LogError, other};
use crate::nearest;

/// The name of standard input on a command line, and in messages.
pub(super) const STANDARD_INPUT: [&str; 2] = ["-", "standard input"];

/// What is packed, with the remedy of a file that was not copied whole.
struct Packed<R>(MultiGzDecoder<R>);

impl<R: BufRead> Read for Packed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer).map_err(|error| {
            let fault = format!("the packed log ends early or is damaged ({error}): copy it again");
            io::Error::new(error.kind(), fault)
        })
    }
}

/// The bytes of a file, of a pipe or, for the name `-`, of standard input, unpacked if they are packed with gzip; and
/// the fingerprint that they have when all are read.
///
/// # Errors
/// The file that cannot be read, or is a folder.
pub(super) fn open(path: &Path) -> Result<(Box<dyn Read>, Fingerprint), LogError> {
    /// The first bytes of gzip (RFC 1952, 2.3.1).
    const PACKED: [u8; 2] = [0x1f, 0x8b];
    let unreadable = |error: io::Error| {
        let why = nearest::unreadable(path, &error);
        LogError::in_file(path, format!("the log cannot be read: {why}"))
    };
    let bytes: Box<dyn Read> = if path == Path::new(STANDARD_INPUT[0]) {
        Box::new(io::stdin().lock())
    } else {
        let file = File::open(path).map_err(unreadable)?;
        if file.metadata().map_err(unreadable)?.is_dir() {
            return Err(LogError::in_file(path, other::of_folder(path)));
        }
        Box::new(file)
    };
    let fingerprint = Fingerprint::default();
    let mut bytes = fingerprint.taken_of(bytes);
    let mut first = Vec::new();
    let count = PACKED.len() as u64;
    (&mut bytes)
        .take(count)
        .read_to_end(&mut first)
        .map_err(unreadable)?;
    let is_packed = first == PACKED;
    let whole = Cursor::new(first).chain(bytes);
    let text: Box<dyn Read> = match is_packed {
        true => Box::new(Packed(MultiGzDecoder::new(BufReader::new(whole)))),
        false => Box::new(whole),
    };
    Ok((text, fingerprint))
}
