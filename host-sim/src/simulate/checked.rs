//! Scenarios that can be run: whatever they describe is built once when they are read, so that nothing
//! can fail after output has begun.

use std::path::Path;

use super::Simulation;
use crate::commission::Commissioning;
use crate::scenario::{Fault, Purpose, Scenario, ScenarioError, fetch};

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// File, line, key and what is allowed there.
    pub fn load(path: &Path, purpose: Purpose) -> Result<Self, ScenarioError> {
        Self::parse(&path.display().to_string(), &fetch(path)?, purpose)
    }

    /// Reads a scenario from a text; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(name: &str, text: &str, purpose: Purpose) -> Result<Self, ScenarioError> {
        let build = match purpose {
            Purpose::Commission => commissionable,
            Purpose::Run | Purpose::Replay => build,
        };
        Self::read(name, text, purpose, build)
    }

    /// Whether every part can be built, as is checked when a file is read.
    ///
    /// # Errors
    /// What cannot be built, and why.
    pub fn buildable(&self) -> Result<(), String> {
        build(self).map_err(|fault| fault.to_string())
    }
}

fn build(scenario: &Scenario) -> Result<(), Fault> {
    Simulation::of(scenario).map(drop)
}

fn commissionable(scenario: &Scenario) -> Result<(), Fault> {
    Commissioning::of(scenario).map(drop)
}
