//! Scenarios that can be run. Every part is built once when they are read, so that nothing can fail after output has
//! begun.

use std::path::Path;

use identifier_log::provenance::{Origin, ScenarioText, Task};

#[cfg(feature = "experiments")]
use identifier_core::Settings;

use super::Simulation;
#[cfg(feature = "experiments")]
use super::build::identifier_in;
#[cfg(feature = "experiments")]
use crate::commission::Commissioning;
use crate::scenario::{Fault, Purpose, Scenario, ScenarioError, complete, fetch, read};

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// File, line, key and what is allowed there.
    pub fn load(path: &Path, purpose: Purpose) -> Result<Self, ScenarioError> {
        Self::parse(&path.display().to_string(), &fetch(path)?, purpose)
    }

    /// Reads a scenario from a text. Errors show `name` as the file.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(name: &str, text: &str, purpose: Purpose) -> Result<Self, ScenarioError> {
        read(Self::blank(purpose), name, text, |read| {
            read.checked(purpose)
        })
    }

    /// Reads the scenario of a text that has a file.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn of_text(text: &ScenarioText, purpose: Purpose) -> Result<Self, ScenarioError> {
        Self::parse(&text.file, &text.text, purpose)
    }

    /// Reads the scenario of a result.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn of_origin(origin: &Origin) -> Result<Self, ScenarioError> {
        let purpose = match origin.task {
            Task::Run => Purpose::Run,
            Task::Replay { .. } => Purpose::Replay,
            Task::Commission => Purpose::Commission,
        };
        Self::of_text(&origin.scenario, purpose)
    }

    /// The same scenario with what follows from its values, checked for a purpose as one that is read.
    ///
    /// # Errors
    /// The key that is not allowed, or that something cannot be built from.
    pub fn checked(self, purpose: Purpose) -> Result<Self, Fault> {
        complete(self, purpose, built_for(purpose))
    }

    /// Checks that every part can be built, as when a file is read.
    ///
    /// # Errors
    /// The part that cannot be built, and why.
    pub fn buildable(&self) -> Result<(), String> {
        build(self).map_err(|fault| fault.to_string())
    }

    /// Checks that the identifier can be built in `f64` from settings.
    ///
    /// # Errors
    /// The key that it cannot be built from.
    #[cfg(feature = "experiments")]
    pub fn identifiable_with(&self, settings: &Settings) -> Result<(), Fault> {
        identifier_in::<f64>(self, settings).map(drop)
    }
}

/// The function that builds everything which a purpose needs.
fn built_for(purpose: Purpose) -> fn(&Scenario) -> Result<(), Fault> {
    match purpose {
        #[cfg(feature = "experiments")]
        Purpose::Commission => commissionable,
        #[cfg(not(feature = "experiments"))]
        Purpose::Commission => |_| Err(Fault::new("commission", "only the program commissions")),
        Purpose::Run | Purpose::Replay => build,
    }
}

fn build(scenario: &Scenario) -> Result<(), Fault> {
    Simulation::build(scenario).map(drop)
}

#[cfg(feature = "experiments")]
fn commissionable(scenario: &Scenario) -> Result<(), Fault> {
    Commissioning::new(scenario).map(drop)
}
