//! The bytes of a log.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::{LogError, other};
use crate::nearest;

/// The bytes of a file, unpacked if it is a `.gz`.
///
/// # Errors
/// The file that cannot be read, or is none.
pub(super) fn open(path: &Path) -> Result<Box<dyn Read>, LogError> {
    let unreadable = |error: io::Error| {
        let why = nearest::unreadable(path, &error);
        LogError::in_file(path, format!("the log cannot be read: {why}"))
    };
    let file = File::open(path).map_err(unreadable)?;
    let found = file.metadata().map_err(unreadable)?;
    if found.is_dir() {
        return Err(LogError::in_file(path, other::of_folder(path)));
    }
    if !found.is_file() {
        return Err(LogError::in_file(
            path,
            "a log is read more than once, so it must be a file: save the piped data to a file first"
                .to_owned(),
        ));
    }
    let packed = path.extension().is_some_and(|end| end == "gz");
    Ok(if packed {
        Box::new(MultiGzDecoder::new(BufReader::new(file)))
    } else {
        Box::new(file)
    })
}
