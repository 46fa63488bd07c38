//! The traces and rows of an experiment, and its results.

use std::sync::atomic::Ordering;

use host_sim::IdentifiedScenario;
use host_sim::scenario::Scenario;
use identifier_log::experiment::Sample;
use identifier_log::verdict::{Status, VerdictReason};

use super::fault::Fault;
use super::output::Results;
use super::output_file::Output;
use super::progress::Progress;
use super::streamed::Streamed;
use super::{call, interruption};
use crate::csv::Rows;
use crate::present::{self, Experiment, ExperimentTraces};

/// Takes in an experiment sample by sample. Picture and rows are those of its last pass.
#[derive(Debug)]
pub(super) struct Recording {
    title: String,
    last_pass: u32,
    pass: u32,
    traces: Option<ExperimentTraces>,
    rows: Option<Streamed<Rows<Output>>>,
    progress: Progress,
}

impl Recording {
    /// Of so many samples in all passes over the scenario, or over logs, for the requested results; their page has a
    /// `title`.
    pub(super) fn new(
        title: String,
        scenario: &Scenario,
        samples: u64,
        passes_over_logs: Option<u32>,
        results: &mut Results,
    ) -> Self {
        let unit = scenario.motion_unit();
        let of_log = passes_over_logs.map(|_| scenario.identifier.law);
        Self {
            title,
            last_pass: passes_over_logs.unwrap_or(1).saturating_sub(1),
            pass: 0,
            traces: results.show_traces().then(ExperimentTraces::default),
            rows: (results.csv.take())
                .map(|csv| Streamed::begin(csv, |out| Rows::of_experiment(out, unit, of_log))),
            progress: Progress::of_samples(samples),
        }
    }

    /// A sample of a pass, by its number from 0.
    pub(super) fn add(&mut self, pass: u32, sample: &Sample) {
        self.progress.advance();
        if pass != self.pass {
            self.pass = pass;
            if let Some(traces) = &mut self.traces {
                *traces = ExperimentTraces::default();
            }
        }
        if let Some(traces) = &mut self.traces {
            traces.add(sample);
        }
        if let Some(rows) = self.rows.as_mut().filter(|_| pass == self.last_pass) {
            rows.write(|rows| rows.sample(sample));
        }
    }

    /// Publishes the results and returns their verdict.
    ///
    /// # Errors
    /// An experiment that was aborted or interrupted, and those of [`Results::publish`].
    pub(super) fn publish(
        self,
        results: Results,
        found: &IdentifiedScenario,
    ) -> Result<Status, Fault> {
        let summary = &found.summary;
        let page = present::experiment(&Experiment {
            title: &self.title,
            command: &call::command(),
            scenario: &found.scenario,
            summary,
            traces: self.traces.as_ref(),
            seen: found.seen.as_ref(),
        });
        let written = [self.rows.map(|rows| rows.finish(Rows::finish))];
        results.publish(&page, 2, true, summary, written)?;
        match summary.status() {
            _ if summary.verdict.reason == VerdictReason::Stopped => {
                let text = "interrupted: the result has the data until then";
                Err(Fault::Interrupted(text.to_owned()))
            }
            Status::Aborted => Err(Fault::Other(summary.reason.clone())),
            status => Ok(status),
        }
    }
}

/// Does a fit that Ctrl-C ends with the estimates so far.
pub(super) fn interruptible<R>(fit: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> R) -> R {
    let progress = Progress::of_a_search();
    fit(&|| {
        progress.advance();
        // Before a fit begins, nothing is worth keeping.
        !interruption::end_requested().load(Ordering::Relaxed)
    })
}
