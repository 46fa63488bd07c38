//! The simulated servo, moved by its caller from step to step.

use std::sync::{Mutex, PoisonError};

use host_sim::scenario::Purpose;
use pyo3::prelude::*;
use virtual_servo::Servo;

use crate::fault::value_error;
use crate::origin::Read;

/// A servo with its state.
#[pyclass(frozen)]
#[derive(Debug)]
pub(crate) struct SimulatedServo(Mutex<Servo>);

#[pymethods]
impl SimulatedServo {
    /// At rest at position zero: the plant of a scenario's `text`, in steps of its sample time.
    ///
    /// # Errors
    /// `ValueError`: the key that is missing or not allowed.
    #[new]
    fn new(file: &str, text: &str) -> PyResult<Self> {
        let read = Read::new(file, text, Purpose::Run)?;
        let scenario = &read.scenario;
        let plant = scenario
            .plant
            .ok_or_else(|| read.fault("a table [plant] is needed"))?;
        let time = scenario
            .checked_units()
            .map_err(|fault| read.fault(fault))?
            .sample_time();
        let servo = Servo::at_rest(&plant, &scenario.effects, time, scenario.noise_seed());
        Ok(Self(Mutex::new(servo.map_err(value_error)?)))
    }

    /// Moves one step under a command; position, rad, and velocity, rad/s, at its end.
    fn step(&self, command: f64) -> (f64, f64) {
        let mut servo = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        servo.advance(command);
        (servo.position(), servo.velocity())
    }
}
