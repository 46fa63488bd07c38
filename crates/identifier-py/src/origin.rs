//! A scenario's text, and results with it.

use host_sim::scenario::{Purpose, Scenario};
use identifier_log::provenance::{Origin, ScenarioText, Task, WithOrigin};
use pyo3::prelude::*;
use serde::Serialize;

use crate::fault::value_error;

/// A scenario and the text that it was read from.
#[derive(Debug)]
pub(crate) struct Read {
    text: ScenarioText,
    pub(crate) scenario: Scenario,
}

impl Read {
    /// Reads a scenario's text, which has a `file` in messages.
    ///
    /// # Errors
    /// `ValueError`: line, key and what is allowed there.
    pub(crate) fn new(file: &str, text: &str, purpose: Purpose) -> PyResult<Self> {
        let text = ScenarioText {
            file: file.to_owned(),
            text: text.to_owned(),
        };
        let scenario = Scenario::of_text(&text, purpose).map_err(value_error)?;
        Ok(Self { text, scenario })
    }

    /// A fault of the scenario's contents, with its file.
    pub(crate) fn fault(&self, fault: impl std::fmt::Display) -> PyErr {
        value_error(format!("{}: {fault}", self.text.file))
    }

    /// A result of the scenario as JSON, as `servo-id` writes it.
    ///
    /// # Errors
    /// None in practice: every result can be written.
    pub(crate) fn json(&self, task: Task, result: &impl Serialize) -> PyResult<String> {
        let with_origin = WithOrigin {
            result: Some(result),
            origin: &Origin::new(
                servo_id::VERSION,
                task,
                &self.text,
                self.scenario.noise_seed(),
            ),
        };
        serde_json::to_string(&with_origin).map_err(value_error)
    }
}
