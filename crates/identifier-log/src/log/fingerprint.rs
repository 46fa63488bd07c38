//! The fingerprint of a log: the SHA-256 of its content, taken as it is read where this program reads it.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::rc::Rc;

use sha2::{Digest, Sha256};

/// The sum of the bytes that were read so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Fingerprint(Rc<RefCell<Sha256>>);

impl Fingerprint {
    /// The same bytes, which are summed up as they are read.
    pub(super) fn taken_of<R: Read>(&self, mut bytes: R) -> impl Read + use<R> {
        let sum = self.clone();
        Taken(move |buffer: &mut [u8]| {
            let read = bytes.read(buffer)?;
            sum.0.borrow_mut().update(&buffer[..read]);
            Ok(read)
        })
    }

    /// The sum in hexadecimal digits.
    pub(super) fn digits(&self) -> String {
        let sum = self.0.borrow().clone().finalize();
        sum.iter().fold(String::new(), |mut digits, byte| {
            // Nothing can fail that is written into memory.
            let _ = write!(digits, "{byte:02x}");
            digits
        })
    }
}

/// That of a file; none if it cannot be read.
pub(crate) fn of_file(path: &Path) -> Option<String> {
    let sum = Fingerprint::default();
    let mut bytes = sum.taken_of(File::open(path).ok()?);
    io::copy(&mut bytes, &mut io::sink()).ok()?;
    Some(sum.digits())
}

struct Taken<F>(F);

impl<F: FnMut(&mut [u8]) -> io::Result<usize>> Read for Taken<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        (self.0)(buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_that_of_the_standard() {
        let sum = Fingerprint::default();
        let read = io::read_to_string(sum.taken_of(&b"abc"[..])).expect("bytes in memory");
        assert_eq!(read, "abc");
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sum.digits(), expected);
    }
}
