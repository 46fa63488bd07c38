//! Prediction of a log by a servo that was identified.

use host_sim::replay::fitted;
use host_sim::scenario::Purpose;
use identifier_log::FoundServo;
use identifier_log::log::{Row, Table};
use identifier_log::result::Prediction;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{self, Source};
use crate::fault::value_error;
use crate::identify::opened;
use crate::origin::Read;

/// Predicts a log by a servo that was identified with the scenario of a `text`: the entry of `predictions` as JSON, and the
/// samples with the residual.
///
/// # Errors
/// `ValueError`: the line and column of the log, or a servo that moves beyond every bound.
#[pyfunction]
pub(crate) fn predict<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    servo: &[u8],
    logs: Vec<Source>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let numbers = servo
        .as_chunks()
        .0
        .iter()
        .map(|bytes| f64::from_ne_bytes(*bytes));
    let numbers: Vec<f64> = numbers.collect();
    let numbers = numbers
        .try_into()
        .map_err(|_| value_error("servo: it is none of this version"))?;
    let tables = Source::tables(logs, py)?;
    let (json, columns) = py.detach(|| {
        let table = Table::joined(&tables).map_err(value_error)?;
        let read = Read::new(file, text, Purpose::Replay)?;
        let log = opened(&read.scenario, &table)?;
        let scenario = fitted(read.scenario.clone(), std::slice::from_ref(&log));
        let found = identifier_log::predict::predict(&scenario, &FoundServo::of_numbers(&numbers), &log);
        let found = found.map_err(|fault| read.fault(fault))?;
        let json = serde_json::to_string(&Prediction::new(&log, false, &found));
        let open_loop = found.open_loop.ok_or_else(|| {
            let text = "the servo does not move, or its model moves beyond every bound: check its columns and units";
            value_error(format!("{}: {text}", table.path.display()))
        })?;
        let column = |of: &dyn Fn(&Row) -> Option<f64>| {
            let rows = log.rows().iter();
            rows.map(|row| of(row).unwrap_or(f64::NAN)).collect()
        };
        let columns = [
            ("time", column(&|row| Some(row.time))),
            ("reference", column(&|row| row.reference)),
            ("position", column(&|row| Some(row.position))),
            ("command", column(&|row| row.command)),
            ("output_error", open_loop.errors),
        ];
        PyResult::Ok((json.map_err(value_error)?, columns))
    })?;
    Ok((json, columns::by_name(py, columns)?))
}
