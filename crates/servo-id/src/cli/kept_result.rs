//! A result that an earlier call wrote.

use std::fs;
use std::path::Path;

use identifier_log::nearest;

use super::fault::Fault;

/// Its text.
///
/// # Errors
/// A file that cannot be read, with similar names beside it.
pub(super) fn text(path: &Path) -> Result<String, Fault> {
    fs::read_to_string(path)
        .map_err(|error| nearest::unreadable(path, &error))
        .map_err(|why| Fault::of_file(path, format!("the result cannot be read: {why}")))
}
