//! What is kept of an experiment while it runs: never more than a bounded part, however long it takes.

use std::io;

use super::fault::Fault;
use super::files::{Output, io_error};
use super::live::Live;
use super::live_experiment::LiveExperiment;
use crate::analysis::{Summariser, Summary};
use crate::experiment::{Outcome, Sample};
use crate::report::csv::TraceWriter;
use crate::report::panels::Traces;
use crate::scenario::Scenario;

/// Takes in an experiment sample by sample. The summary is that of all passes; what the verdict looks at once
/// more, the picture and the rows are those of the last.
#[derive(Debug)]
pub(super) struct Recording {
    passes_to_come: u32,
    summariser: Summariser,
    traces: Option<Traces>,
    rows: Option<Rows>,
    live: Option<LiveExperiment>,
}

/// What an experiment that has ended leaves.
#[derive(Debug)]
pub(super) struct Recorded {
    pub(super) summary: Summary,
    pub(super) traces: Option<Traces>,
    pub(super) rows: Option<Rows>,
    pub(super) live: Option<Live>,
}

impl Recording {
    /// Of `passes` passes, which together last so long, s; traces and rows only where they are wanted.
    pub(super) fn new(
        scenario: &Scenario,
        duration: f64,
        passes: u32,
        rows: Option<Rows>,
        traces: Option<Traces>,
        live: Option<LiveExperiment>,
    ) -> Self {
        Self {
            passes_to_come: passes.saturating_sub(1),
            summariser: Summariser::lasting(scenario, duration),
            traces,
            rows,
            live,
        }
    }

    /// A sample.
    pub(super) fn add(&mut self, sample: &Sample) {
        self.summariser.add(sample);
        if let Some(traces) = &mut self.traces {
            traces.add(sample);
        }
        if self.passes_to_come == 0
            && let Some(rows) = &mut self.rows
        {
            rows.add(sample);
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
            live: self.live.map(LiveExperiment::into_live),
        }
    }
}

/// The rows of a trace on their way into a file.
#[derive(Debug)]
pub(super) struct Rows {
    /// The file's name.
    name: String,
    /// The first failure ends the writing.
    writer: Result<TraceWriter<Output>, io::Error>,
}

impl Rows {
    /// Begins a file with the heading.
    pub(super) fn begin(output: Output) -> Self {
        Self {
            name: output.name().display().to_string(),
            writer: TraceWriter::new(output).map_err(io_error),
        }
    }

    fn add(&mut self, sample: &Sample) {
        if let Ok(writer) = &mut self.writer
            && let Err(error) = writer.add(sample)
        {
            self.writer = Err(io_error(error));
        }
    }

    /// Ends the file; whatever went wrong with it on the way is said now.
    pub(super) fn finish(self) -> Result<Output, Fault> {
        self.writer
            .and_then(TraceWriter::finish)
            .map_err(|error| Fault::unwritable(&self.name, &error))
    }
}
