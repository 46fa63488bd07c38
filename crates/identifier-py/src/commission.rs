//! Commissioning of the simulated drive.

use host_sim::commission::{Commissioning, Recorded};
use host_sim::result::CommissioningResult;
use host_sim::scenario::Purpose;
use identifier_log::provenance::Task;
use pyo3::prelude::*;

use crate::origin::Read;

/// Commissions the servo of a scenario; the result as JSON.
///
/// # Errors
/// `ValueError`: the key of the scenario that is missing or not allowed.
#[pyfunction]
pub(crate) fn commission(py: Python<'_>, file: &str, text: &str) -> PyResult<String> {
    py.detach(|| {
        let read = Read::new(file, text, Purpose::Commission)?;
        let of_scenario = |fault| read.fault(fault);
        let machine = Commissioning::new(&read.scenario).map_err(of_scenario)?;
        let largest = machine.largest_motion();
        let limits = machine.settings().limits;
        let before = machine.gains_before().copied();
        let mut recorded = Recorded::default();
        let outcome = machine
            .run(&mut |sample| recorded.add(sample))
            .map_err(of_scenario)?;
        let result = CommissioningResult::new(
            &read.scenario,
            &limits,
            &largest,
            before.as_ref(),
            &outcome,
            &recorded.effects(&read.scenario, outcome.reason()),
        );
        read.json(Task::Commission, &result)
    })
}
