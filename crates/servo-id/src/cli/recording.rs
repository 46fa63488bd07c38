//! The bounded record of a run or a replay.

use std::sync::atomic::Ordering;

use host_sim::FoundServo;
use host_sim::analysis::{Seen, Status, Summariser};
use host_sim::experiment::{Outcome, Sample};
use host_sim::result::ReplayNotes;
use host_sim::scenario::Scenario;
use identifier_log::verdict::VerdictReason;

use super::call;
use super::fault::Fault;
use super::interruption;
use super::output::Results;
use super::output_file::Output;
use super::progress::Progress;
use super::streamed::Streamed;
use crate::csv::Rows;
use crate::present::{self, Experiment, ExperimentTraces};

/// Takes in an experiment sample by sample. The summary is that of all passes; its evidence, picture and
/// rows are those of the last.
#[derive(Debug)]
pub(super) struct Recording<'a> {
    title: String,
    scenario: &'a Scenario,
    passes_to_come: u32,
    summariser: Summariser,
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

impl<'a> Recording<'a> {
    /// Of `passes` passes, which together last `duration`, s, for the requested results; their page has a `title`.
    pub(super) fn new(
        title: String,
        scenario: &'a Scenario,
        duration: f64,
        passes: u32,
        results: &mut Results,
    ) -> Self {
        let is_shown = results.show_traces() || results.csv.is_some();
        let is_held = is_shown && scenario.identifier.law.takes_whole_record();
        Self {
            held: is_held.then(Default::default),
            title,
            scenario,
            passes_to_come: passes.saturating_sub(1),
            summariser: Summariser::lasting(scenario, duration),
            traces: results.show_traces().then(ExperimentTraces::default),
            rows: (results.csv.take()).map(|csv| Streamed::begin(csv, Rows::of_experiment)),
            progress: Progress::of_samples((duration / scenario.sample_time()) as u64),
        }
    }

    /// A sample.
    pub(super) fn add(&mut self, sample: &Sample) {
        self.summariser.add(sample);
        self.progress.advance();
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
        if let Some(rows) = self.rows.as_mut().filter(|_| self.passes_to_come == 0) {
            rows.write(|rows| rows.sample(sample));
        }
    }

    /// The next pass begins.
    pub(super) fn begin_pass(&mut self) {
        self.passes_to_come = self.passes_to_come.saturating_sub(1);
        self.summariser.begin_pass();
        if let Some(traces) = &mut self.traces {
            *traces = ExperimentTraces::default();
        }
        if let Some((held, _)) = &mut self.held {
            held.clear();
        }
    }

    /// The residual of each sample, for an estimator that fits all of them. Held samples are shown with it.
    fn seen(&mut self) -> Option<Seen> {
        let _ = self.fit_record();
        let seen = self.summariser.seen(self.scenario);
        let (held, last) = self.held.take().unwrap_or_default();
        let Some(last) = last else { return seen };
        for (place, one) in held.into_iter().enumerate() {
            self.show(&Sample {
                time: one.time,
                reference: one.reference,
                position: one.position,
                command: one.command,
                output_error: seen.as_ref().map(|seen| seen.errors[place]),
                ..last
            });
        }
        seen
    }

    /// The servo found by the fit of the whole record, also of a fit that was ended early. None for other estimators.
    pub(super) fn fit_record(&mut self) -> Option<FoundServo> {
        if !self.scenario.identifier.law.takes_whole_record() {
            return None;
        }
        let stop = interruption::end_requested();
        let progress = Progress::of_a_search();
        self.summariser.fit_record(self.scenario, &|| {
            progress.advance();
            !stop.load(Ordering::Relaxed)
        })
    }

    /// The estimates predicted a log that did not enter them with this relative error.
    pub(super) fn predicted(&mut self, error: f64) {
        self.summariser.predicted(error);
    }

    /// Publishes the results, with `notes` on the replayed logs, and returns their verdict.
    ///
    /// # Errors
    /// An experiment that was aborted or interrupted, and those of [`Results::publish`].
    pub(super) fn conclude(
        mut self,
        results: Results,
        outcome: Outcome,
        notes: ReplayNotes,
    ) -> Result<Status, Fault> {
        let seen = outcome.abort.is_none().then(|| self.seen()).flatten();
        let mut summary = self.summariser.finish(self.scenario, outcome);
        summary.replay = notes;
        let page = present::experiment(&Experiment {
            title: &self.title,
            command: &call::command(),
            scenario: self.scenario,
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
