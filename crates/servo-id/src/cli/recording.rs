//! The outputs of a run or a replay, gathered sample by sample.

use std::sync::atomic::Ordering;

use host_sim::Identified;
use host_sim::analysis::Status;
use host_sim::experiment::Sample;
use host_sim::scenario::Scenario;
use host_sim::verdict::VerdictReason;

use super::call;
use super::fault::Fault;
use super::interruption;
use super::output::Results;
use super::output_file::Output;
use super::progress::Progress;
use super::streamed::Streamed;
use crate::csv::Rows;
use crate::present::{self, Experiment, ExperimentTraces};

/// Takes in an experiment sample by sample. Picture and rows are those of the last pass.
#[derive(Debug)]
pub(super) struct Recording {
    title: String,
    passes: u32,
    pass: u32,
    traces: Option<ExperimentTraces>,
    rows: Option<Streamed<Rows<Output>>>,
    /// The samples of a law whose model is known at the end, where they are shown: what differs, and the last of them.
    held: Option<(Vec<Held>, Option<Sample>)>,
    progress: Progress,
}

/// The values shown for a sample and its model.
#[derive(Debug, Clone, Copy)]
struct Held {
    time: f64,
    reference: f64,
    position: f64,
    command: f64,
}

impl Recording {
    /// Of `passes` passes, together of so many `samples`, for the requested results; their page has a `title`.
    pub(super) fn new(
        title: String,
        scenario: &Scenario,
        samples: u64,
        passes: u32,
        results: &mut Results,
    ) -> Self {
        let unit = scenario.motion_unit();
        let is_shown = results.show_traces() || results.csv.is_some();
        let is_held = is_shown && scenario.identifier.law.takes_whole_record();
        Self {
            held: is_held.then(Default::default),
            title,
            passes,
            pass: 0,
            traces: results.show_traces().then(ExperimentTraces::default),
            rows: (results.csv.take())
                .map(|csv| Streamed::begin(csv, |out| Rows::of_experiment(out, unit))),
            progress: Progress::of_samples(samples),
        }
    }

    /// A sample of a pass.
    pub(super) fn add(&mut self, pass: u32, sample: &Sample) {
        self.progress.advance();
        if pass != self.pass {
            self.pass = pass;
            if let Some(traces) = &mut self.traces {
                *traces = ExperimentTraces::default();
            }
            if let Some((held, _)) = &mut self.held {
                held.clear();
            }
        }
        match &mut self.held {
            Some((held, last)) => {
                held.push(Held {
                    time: sample.time,
                    reference: sample.reference,
                    position: sample.position,
                    command: sample.command,
                });
                *last = Some(*sample);
            }
            None => self.show(sample),
        }
    }

    fn show(&mut self, sample: &Sample) {
        if let Some(traces) = &mut self.traces {
            traces.add(sample);
        }
        if let Some(rows) = self.rows.as_mut().filter(|_| self.pass + 1 == self.passes) {
            rows.write(|rows| rows.sample(sample));
        }
    }

    /// Shows the samples that waited for their model, with its `errors`, if there is one.
    fn show_held(&mut self, errors: Option<&[f64]>) {
        let Some((held, Some(last))) = self.held.take() else {
            return;
        };
        for (place, one) in held.into_iter().enumerate() {
            self.show(&Sample {
                time: one.time,
                reference: one.reference,
                position: one.position,
                command: one.command,
                output_error: errors.map(|errors| errors[place]),
                ..last
            });
        }
    }

    /// Publishes what was identified and returns its verdict.
    ///
    /// # Errors
    /// An experiment that was aborted or interrupted, and those of [`Results::publish`].
    pub(super) fn conclude(mut self, results: Results, found: Identified) -> Result<Status, Fault> {
        let Identified {
            scenario,
            summary,
            seen,
            ..
        } = found;
        // An aborted experiment has no model, and its samples are not shown.
        if summary.status() != Status::Aborted {
            self.show_held(seen.as_ref().map(|seen| &seen.errors[..]));
        }
        let page = present::experiment(&Experiment {
            title: &self.title,
            command: &call::command(),
            scenario: &scenario,
            summary: &summary,
            traces: self.traces.as_ref(),
            seen: seen.as_ref(),
        });
        let written = [self.rows.map(|rows| rows.finish(Rows::finish))];
        results.publish(&page, 2, true, &summary, written)?;
        match summary.status() {
            _ if summary.verdict.reason == VerdictReason::Stopped => {
                let text = "interrupted: the result has the data until then";
                Err(Fault::Interrupted(text.to_owned()))
            }
            Status::Aborted => Err(Fault::Other(summary.reason)),
            status => Ok(status),
        }
    }
}

/// Calls an experiment with what tells its fit whether it goes on: Ctrl-C ends it. Its progress is shown.
pub(super) fn with_fit<T>(experiment: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> T) -> T {
    let progress = Progress::of_a_search();
    experiment(&|| {
        progress.advance();
        // Before a fit begins, nothing is worth keeping.
        !interruption::end_requested().load(Ordering::Relaxed)
    })
}
