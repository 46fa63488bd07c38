//! The fingerprint of a file: the SHA-256 of its content.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};

/// The SHA-256 of a file, in hexadecimal digits.
pub(super) fn of_file(path: &Path) -> io::Result<String> {
    /// Bytes that are read at once.
    const AT_ONCE: usize = 1 << 16;
    let mut file = File::open(path)?;
    let mut sum = Sha256::new();
    let mut part = vec![0; AT_ONCE];
    loop {
        match file.read(&mut part) {
            Ok(0) => break,
            Ok(read) => sum.update(&part[..read]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    let mut text = String::new();
    for byte in sum.finalize() {
        // Nothing can fail that is written into memory.
        let _ = write!(text, "{byte:02x}");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_sum_is_that_of_the_standard() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("abc");
        std::fs::write(&file, "abc").expect("written");
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(super::of_file(&file).expect("read"), expected);
    }
}
