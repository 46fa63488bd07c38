//! Experiments on the simulated servo.

use host_sim::identify_run;
use host_sim::scenario::Purpose;
use identifier_log::experiment::Sample;
use identifier_log::provenance::Task;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns;
use crate::origin::Read;
use crate::picture::picture;

/// Runs a scenario; the result as JSON, its trace and its picture.
///
/// # Errors
/// `ValueError`: the key of the scenario that is missing or not allowed.
#[pyfunction]
#[pyo3(signature = (file, text, *, trace))]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    trace: bool,
) -> PyResult<(String, Bound<'py, PyDict>, String)> {
    let (json, samples, picture) = py.detach(|| {
        let read = Read::new(file, text, Purpose::Run)?;
        let mut samples = Vec::new();
        let mut observe = |_, sample: &Sample| samples.extend(trace.then_some(*sample));
        let found = identify_run(read.scenario.clone(), &|| true, &mut observe);
        let found = found.map_err(|fault| read.fault(fault))?;
        let picture = picture(&found, &samples);
        PyResult::Ok((read.json(Task::Run, &found.summary)?, samples, picture))
    })?;
    Ok((json, columns::of_samples(py, &samples)?, picture))
}
