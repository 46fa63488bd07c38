//! Identification while samples are taken.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use host_sim::replay::OnlineIdentifier;
use host_sim::scenario::Purpose;
use identifier_core::parameters::{Parameter, ServoParameters};
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;

use crate::fault::value_error;
use crate::origin::Read;

/// A number per parameter, by name.
type Named = BTreeMap<&'static str, f64>;

/// An identifier with its state.
#[pyclass(frozen)]
#[derive(Debug)]
pub(crate) struct Online(Mutex<OnlineIdentifier>);

#[pymethods]
impl Online {
    /// At its start, with the scenario of a `text`.
    ///
    /// # Errors
    /// `ValueError`: the key that is missing or not allowed.
    #[new]
    fn new(file: &str, text: &str) -> PyResult<Self> {
        let read = Read::new(file, text, Purpose::Replay)?;
        let identifier = OnlineIdentifier::new(read.scenario.clone());
        let identifier = identifier.map_err(|fault| read.fault(fault))?;
        Ok(Self(Mutex::new(identifier)))
    }

    /// A sample.
    ///
    /// # Errors
    /// `ValueError`: a number that is not allowed.
    fn learn(&self, position: f64, command: f64) -> PyResult<()> {
        let learnt = self.identifier().learn(position, command);
        learnt.map_err(value_error)
    }

    /// The samples of two columns of one length.
    ///
    /// # Errors
    /// `ValueError`: the sample that has a number that is not allowed; those before it have been learnt from.
    fn learn_columns(
        &self,
        py: Python<'_>,
        position: PyBuffer<f64>,
        command: PyBuffer<f64>,
    ) -> PyResult<()> {
        let (position, command) = (position.to_vec(py)?, command.to_vec(py)?);
        py.detach(|| {
            let mut identifier = self.identifier();
            for (sample, (position, command)) in position.into_iter().zip(command).enumerate() {
                let learnt = identifier.learn(position, command);
                learnt.map_err(|fault| value_error(format!("sample {sample}: {fault}")))?;
            }
            Ok(())
        })
    }

    fn resume(&self) {
        self.identifier().resume();
    }

    /// Samples so far, the estimates, their standard errors if the estimator has them, and the names of those at a
    /// bound.
    fn found(&self) -> (u64, Named, Option<Named>, Vec<&'static str>) {
        let identifier = self.identifier();
        let estimated = identifier.estimated();
        let named = |found: &ServoParameters| -> Named {
            let of = |one: &Parameter| (one.name(), found.get(*one));
            estimated.iter().map(of).collect()
        };
        let bounds = identifier.at_bounds();
        let at_bound = estimated.iter().filter(|one| bounds.get(**one));
        (
            identifier.samples(),
            named(&identifier.estimates()),
            identifier.standard_errors().as_ref().map(named),
            at_bound.map(|one| one.name()).collect(),
        )
    }
}

impl Online {
    /// A panic in another call leaves a state that is sound: a sample is learnt from whole or not at all.
    fn identifier(&self) -> MutexGuard<'_, OnlineIdentifier> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
