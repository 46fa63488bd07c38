//! Columns of numbers between numpy and the library.

use std::path::PathBuf;

use identifier_log::experiment::Sample;
use identifier_log::log::Table;
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::fault::value_error;

/// A log: a text, or columns, each a one-dimensional buffer of float64, with the name that the log has in messages.
#[derive(FromPyObject)]
pub(crate) enum Source {
    Text(PathBuf),
    Columns(PathBuf, Vec<(String, PyBuffer<f64>)>),
}

impl Source {
    /// The columns of each log, which are read once.
    ///
    /// # Errors
    /// `ValueError`: a text that cannot be read; the column that has more than one dimension, or another length than the others.
    pub(crate) fn tables(logs: Vec<Self>, py: Python<'_>) -> PyResult<Vec<Table>> {
        logs.into_iter().map(|log| log.table(py)).collect()
    }

    fn table(self, py: Python<'_>) -> PyResult<Table> {
        let (name, buffers) = match self {
            Self::Text(path) => return py.detach(|| Table::read(&path).map_err(value_error)),
            Self::Columns(name, buffers) => (name, buffers),
        };
        let mut columns = Vec::new();
        for (name, buffer) in buffers {
            if buffer.dimensions() != 1 {
                return Err(value_error(format!(
                    "{name} has {} dimensions: a column of a log has one, a number per sample",
                    buffer.dimensions()
                )));
            }
            columns.push((name, buffer.to_vec(py)?));
        }
        Table::of_columns(&name.display().to_string(), columns).map_err(value_error)
    }
}

/// The samples of an experiment as columns by name; none of no samples.
pub(crate) fn of_samples<'py>(py: Python<'py>, samples: &[Sample]) -> PyResult<Bound<'py, PyDict>> {
    const NAMES: [&str; 13] = [
        "time",
        "reference",
        "position",
        "command",
        "output_error",
        "a",
        "b",
        "coulomb",
        "load",
        "std_error_a",
        "std_error_b",
        "std_error_coulomb",
        "std_error_load",
    ];
    let mut columns: [Vec<f64>; NAMES.len()] = Default::default();
    for sample in samples {
        let numbers = sample.measured().into_iter().chain(sample.identified());
        for (column, number) in columns.iter_mut().zip(numbers) {
            column.push(number.unwrap_or(f64::NAN));
        }
    }
    let named = NAMES.into_iter().zip(columns);
    by_name(py, named.filter(|_| !samples.is_empty()))
}

/// Columns by name, each the bytes of float64.
pub(crate) fn by_name<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (&'static str, Vec<f64>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    for (name, column) in columns {
        result.set_item(name, bytes(py, &column))?;
    }
    Ok(result)
}

/// Numbers as the bytes of float64.
pub(crate) fn bytes<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = numbers.iter().copied().flat_map(f64::to_ne_bytes).collect();
    PyBytes::new(py, &bytes)
}
