//! Faults of a call.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// A `ValueError` with the message of a fault, the options of the command line in it as keywords: `--position-unit` is
/// `position_unit`.
pub(crate) fn value_error(fault: impl Display) -> PyErr {
    PyValueError::new_err(in_keywords(&fault.to_string()))
}

fn in_keywords(text: &str) -> String {
    let mut parts = text.split("--");
    let mut result = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_of_name = |c: char| c.is_ascii_lowercase() || c == '-';
        let end = part.find(|c| !is_of_name(c)).unwrap_or(part.len());
        let (option, rest) = part.split_at(end);
        result.push_str(&option.replace('-', "_"));
        result.push_str(rest);
    }
    result
}
