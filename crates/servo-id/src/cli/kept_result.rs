//! A result that an earlier call wrote.

use std::fs;
use std::path::Path;

use identifier_log::nearest;
use identifier_log::result::KeptResult;

use super::fault::Fault;

/// Reads it.
///
/// # Errors
/// A file that cannot be read, with similar names beside it, or is no result.
pub(super) fn read(path: &Path) -> Result<KeptResult, Fault> {
    let text = fs::read_to_string(path)
        .map_err(|error| nearest::unreadable(path, &error))
        .map_err(|why| Fault::of_file(path, format!("the result cannot be read: {why}")))?;
    KeptResult::read(&text).map_err(|error| Fault::of_file(path, error))
}
