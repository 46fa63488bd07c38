//! The bounded record of an experiment while it runs.

use super::files::{Output, io_error};
use super::live::Live;
use super::live_experiment::LiveExperiment;
use super::progress::Progress;
use super::streamed::Streamed;
use crate::analysis::Summariser;
use crate::experiment::{Outcome, Sample};
use crate::log::mcap::{Recorder, trace};
use crate::present::traces::Traces;
use crate::report::csv::TraceWriter;
use crate::result::Summary;
use crate::scenario::Scenario;

/// The rows of a trace on their way into a file.
pub(super) type Rows = Streamed<TraceWriter<Output>>;

/// The messages of a trace on their way into a file.
pub(super) type Messages = Streamed<Recorder<Output>>;

/// Takes in an experiment sample by sample. The summary is that of all passes; what the verdict looks at once
/// more, the picture, the rows and the messages are those of the last.
#[derive(Debug)]
pub(super) struct Recording {
    passes_to_come: u32,
    summariser: Summariser,
    traces: Option<Traces>,
    rows: Option<Rows>,
    messages: Option<Messages>,
    live: Option<LiveExperiment>,
    progress: Progress,
}

/// What an experiment that has ended leaves.
#[derive(Debug)]
pub(super) struct Recorded {
    pub(super) summary: Summary,
    pub(super) traces: Option<Traces>,
    pub(super) rows: Option<Rows>,
    pub(super) messages: Option<Messages>,
    pub(super) live: Option<Live>,
}

impl Recording {
    /// Of `passes` passes, which together last so long, s; traces, rows and messages only where they are
    /// wanted.
    pub(super) fn new(
        scenario: &Scenario,
        duration: f64,
        passes: u32,
        rows: Option<Rows>,
        messages: Option<Messages>,
        traces: Option<Traces>,
        live: Option<LiveExperiment>,
    ) -> Self {
        Self {
            passes_to_come: passes.saturating_sub(1),
            summariser: Summariser::lasting(scenario, duration),
            traces,
            rows,
            messages,
            live,
            progress: Progress::of_samples((duration / scenario.sample_time()) as u64),
        }
    }

    /// A sample.
    pub(super) fn add(&mut self, sample: &Sample) {
        self.summariser.add(sample);
        self.progress.advance();
        if let Some(traces) = &mut self.traces {
            traces.add(sample);
        }
        if self.passes_to_come == 0 {
            if let Some(rows) = &mut self.rows {
                rows.write(|rows| rows.add(sample).map_err(io_error));
            }
            if let Some(messages) = &mut self.messages {
                messages.write(|messages| trace::add(messages, sample));
            }
        }
        if let (Some(live), Some(traces)) = (&mut self.live, &self.traces) {
            live.add(&self.summariser, traces);
        }
    }

    /// The next pass begins.
    pub(super) fn begin_pass(&mut self) {
        self.passes_to_come = self.passes_to_come.saturating_sub(1);
        self.summariser.begin_pass();
        if let Some(traces) = &mut self.traces {
            *traces = Traces::default();
        }
    }

    /// The estimates predicted a motion that they have not seen with this relative error.
    pub(super) fn predicted(&mut self, error: f64) {
        self.summariser.predicted(error);
    }

    pub(super) fn finish(self, scenario: &Scenario, outcome: Outcome) -> Recorded {
        let summary = self.summariser.finish(scenario, outcome);
        Recorded {
            summary,
            traces: self.traces,
            rows: self.rows,
            messages: self.messages,
            live: self.live.map(LiveExperiment::into_live),
        }
    }
}
