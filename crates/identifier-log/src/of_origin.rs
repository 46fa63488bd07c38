//! The tables of a log in the scenario of a result, whatever else that has.

use std::sync::LazyLock;

use crate::provenance::{Origin, Task};
use crate::scenario::{Document, Key, Options, ScenarioError, When, keys, read};

/// A scenario that was read once before, as a whole and for a task.
struct OfOrigin {
    options: Options,
    task: Task,
}

impl AsRef<Options> for OfOrigin {
    fn as_ref(&self) -> &Options {
        &self.options
    }
}

impl AsMut<Options> for OfOrigin {
    fn as_mut(&mut self) -> &mut Options {
        &mut self.options
    }
}

impl Document for OfOrigin {
    const IS_WHOLE: bool = false;

    fn keys() -> &'static [Key<Self>] {
        static KEYS: LazyLock<Vec<Key<OfOrigin>>> = LazyLock::new(keys::of_log);
        &KEYS
    }

    fn holds(&self, when: When, states: &dyn Fn(&str) -> bool) -> bool {
        let is_run = match self.task {
            Task::Run => true,
            Task::Replay { .. } => states("plant") && !states("log"),
            Task::Commission => false,
        };
        match when {
            When::Always => true,
            When::InRun => is_run,
            When::Simulated => is_run || self.task == Task::Commission,
            When::Stated => false,
        }
    }
}

impl Options {
    /// Those of a result's origin.
    ///
    /// # Errors
    /// Its scenario is no longer one.
    pub fn of_origin(origin: &Origin) -> Result<Self, ScenarioError> {
        let blank = OfOrigin {
            options: Self::blank(),
            task: origin.task.clone(),
        };
        let is_log = matches!(origin.task, Task::Replay { .. });
        let scenario = &origin.scenario;
        let read = read(blank, &scenario.file, &scenario.text, |mut read| {
            read.options.complete(is_log)?;
            Ok(read)
        })?;
        Ok(read.options)
    }
}
