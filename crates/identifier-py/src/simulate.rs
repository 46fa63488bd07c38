//! Experiments on the simulated servo.

use host_sim::analysis::Summariser;
use host_sim::provenance::Task;
use host_sim::scenario::Purpose;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::Trace;
use crate::origin::Read;

/// Runs a scenario; the result as JSON, and its trace.
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
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let (json, trace) = py.detach(|| {
        let read = Read::new(file, text, Purpose::Run)?;
        let mut trace = Trace::new(trace);
        let mut summariser = Summariser::new(&read.scenario);
        let outcome = host_sim::simulate::run(&read.scenario, &mut |sample| {
            summariser.add(sample);
            trace.add(sample);
        })
        .map_err(|fault| read.fault(fault))?;
        let summary = summariser.finish(&read.scenario, outcome);
        PyResult::Ok((read.json(Task::Run, &summary)?, trace))
    })?;
    Ok((json, trace.into_python(py)?))
}
