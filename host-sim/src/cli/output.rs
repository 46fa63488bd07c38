//! Files that a verb writes.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use serde::Serialize;

use super::fault::Fault;
use crate::experiment::Sample;
use crate::report;

/// The name that stands for standard output.
const STANDARD_OUTPUT: &str = "-";

pub(super) fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == STANDARD_OUTPUT
}

/// Writes a document as JSON to a file, or to standard output for `-`.
pub(super) fn json(path: &Path, document: &impl Serialize) -> Result<(), Fault> {
    let text =
        serde_json::to_string_pretty(document).map_err(|error| Fault::unwritable(path, error))?;
    if is_standard_output(path) {
        writeln!(io::stdout(), "{text}").map_err(|error| Fault::unwritable(path, error))
    } else {
        std::fs::write(path, text + "\n").map_err(|error| Fault::unwritable(path, error))
    }
}

/// Writes a trace as CSV.
pub(super) fn csv(path: &Path, trace: &[Sample]) -> Result<(), Fault> {
    let file = File::create(path).map_err(|error| Fault::unwritable(path, error))?;
    report::csv::write(BufWriter::new(file), trace).map_err(|error| Fault::unwritable(path, error))
}
