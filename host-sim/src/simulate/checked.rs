//! Scenarios that can be run: every part is built once when they are read, so that nothing can fail after
//! output has begun.

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

    /// Checks that every part can be built, as when a file is read.
    ///
    /// # Errors
    /// The part that cannot be built, and why.
    pub fn buildable(&self) -> Result<(), String> {
        build(self).map_err(|fault| fault.to_string())
    }
}

fn build(scenario: &Scenario) -> Result<(), Fault> {
    Simulation::build(scenario).map(drop)
}

fn commissionable(scenario: &Scenario) -> Result<(), Fault> {
    Commissioning::new(scenario).map(drop)
}
