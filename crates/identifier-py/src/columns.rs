//! Columns of numbers between numpy and the library.

use std::path::PathBuf;

use host_sim::experiment::Sample;
use host_sim::log::Table;
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
    /// Its columns, which are read once.
    ///
    /// # Errors
    /// `ValueError`: a text that cannot be read; the column that has more than one dimension, or another length than the others.
    pub(crate) fn table(self, py: Python<'_>) -> PyResult<Table> {
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

/// The names of a trace's columns, in the order of [`Trace::add`].
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

/// The samples of an experiment as columns.
#[derive(Debug)]
pub(crate) struct Trace {
    columns: [Vec<f64>; NAMES.len()],
    is_wanted: bool,
}

impl Trace {
    /// An empty trace, which takes in samples if it `is_wanted`.
    pub(crate) fn new(is_wanted: bool) -> Self {
        Self {
            columns: Default::default(),
            is_wanted,
        }
    }

    /// A sample; NaN where it has no number.
    pub(crate) fn add(&mut self, sample: &Sample) {
        if !self.is_wanted {
            return;
        }
        let numbers = sample.measured().into_iter().chain(sample.identified());
        for (column, number) in self.columns.iter_mut().zip(numbers) {
            column.push(number.unwrap_or(f64::NAN));
        }
    }

    /// What a model that is known at the end leaves of every sample, rad.
    pub(crate) fn leaves(&mut self, errors: Vec<f64>) {
        const OUTPUT_ERROR: usize = 4;
        if self.is_wanted {
            self.columns[OUTPUT_ERROR] = errors;
        }
    }

    /// Its columns by name, each the bytes of float64.
    pub(crate) fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let columns = NAMES.into_iter().zip(self.columns);
        by_name(py, columns.filter(|_| self.is_wanted))
    }
}

/// Columns by name, each the bytes of float64.
pub(crate) fn by_name<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (&'static str, Vec<f64>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    for (name, column) in columns {
        let bytes: Vec<u8> = column.iter().copied().flat_map(f64::to_ne_bytes).collect();
        result.set_item(name, PyBytes::new(py, &bytes))?;
    }
    Ok(result)
}
