//! Many random servos.

use std::sync::atomic::AtomicBool;

use host_sim::result::SweepRun;
use host_sim::scenario::Purpose;
use identifier_core::parameters::Parameter;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::by_name;
use crate::origin::Read;

/// The servos `first` to `first + count` of a sweep: a column per quantity, and the status of each.
///
/// # Errors
/// `ValueError`: the key of the scenario that is missing or not allowed.
#[pyfunction]
pub(crate) fn sweep<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    first: u32,
    count: u32,
    seed: u32,
) -> PyResult<(Bound<'py, PyDict>, Vec<&'static str>)> {
    let runs = py.detach(|| {
        let read = Read::new(file, text, Purpose::Run)?;
        let numbers = first..first.saturating_add(count);
        host_sim::sweep::sweep(
            &read.scenario,
            numbers,
            seed,
            &AtomicBool::new(false),
            &|| (),
        )
        .map_err(|fault| read.fault(fault))
    })?;
    let column = |of: &dyn Fn(&SweepRun) -> f64| runs.iter().map(of).collect::<Vec<_>>();
    let mut columns = vec![("number", column(&|run| run.index.into()))];
    for (parameter, [truth, found]) in Parameter::ALL.into_iter().zip([
        ["true_a", "a"],
        ["true_b", "b"],
        ["true_coulomb", "coulomb"],
        ["true_load", "load"],
    ]) {
        columns.push((truth, column(&|run| run.truth.get(parameter))));
        columns.push((found, column(&|run| run.found.get(parameter))));
    }
    let statuses = runs.iter().map(|run| run.status.name()).collect();
    Ok((by_name(py, columns)?, statuses))
}
