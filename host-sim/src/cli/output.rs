//! What is written of one experiment.

use std::path::{Path, PathBuf};

use super::call;
use super::fault::Fault;
use super::files::{self, Files, Output, Picture};
use super::live::{Live, LiveOptions};
use super::live_experiment::LiveExperiment;
use super::recording::{Recorded, Recording, Rows};
use super::standard_output::say;
use crate::analysis::Status;
use crate::experiment::Outcome;
use crate::replay::Agreement;
use crate::report::json::Document;
use crate::report::logs::{LogDocument, PredictionDocument};
use crate::report::page::{self, Experiment};
use crate::report::panels::{self, Traces};
use crate::report::{residual, table, terms};
use crate::scenario::Scenario;

/// Where the results of one experiment go.
#[derive(Debug, clap::Args)]
pub(super) struct Outputs {
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the trace, one row a sample, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the estimates and signals into this file, .png or .svg; `-` is standard output, as SVG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write a report, one HTML page with everything in it, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    live: LiveOptions,
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

/// The results of one experiment, begun.
#[derive(Debug)]
pub(super) struct Results {
    /// What the report is called.
    title: String,
    json: Option<Output>,
    csv: Option<Output>,
    plot: Option<Picture>,
    report: Option<Output>,
    live: Option<Live>,
    /// Whether one of them has standard output to itself.
    silent: bool,
}

/// What there is to be said of the logs of a replay.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// How well the declared controller reproduces the recorded command.
    pub(super) agreement: Option<Agreement>,
    /// How the logs were read.
    pub(super) logs: Vec<LogDocument>,
    /// What was predicted of logs.
    pub(super) predictions: Vec<PredictionDocument>,
}

impl Outputs {
    /// Begins every file that is asked for, none of which may be among those that are read; the report has
    /// a `title`.
    pub(super) fn begin(&self, title: String, inputs: &[&Path]) -> Result<Results, Fault> {
        let mut files = Files::reading(inputs, self.force);
        Ok(Results {
            title,
            json: files.output(self.json.as_deref())?,
            csv: files.output(self.csv.as_deref())?,
            plot: files.picture(self.plot.as_deref())?,
            report: files.output(self.report.as_deref())?,
            live: self.live.begin()?,
            silent: files.own_standard_output(),
        })
    }
}

impl Results {
    /// What is kept of an experiment of so many passes while it runs; `duration` is that of all
    /// together, s.
    pub(super) fn record(&mut self, scenario: &Scenario, duration: f64, passes: u32) -> Recording {
        let rows = self.csv.take().map(Rows::begin);
        let is_shown = self.plot.is_some() || self.report.is_some() || self.live.is_some();
        let traces = is_shown.then(Traces::default);
        let live = self.live.take();
        let live = live.map(|live| LiveExperiment::new(live, &self.title, scenario, duration));
        Recording::new(scenario, duration, passes, rows, traces, live)
    }

    /// Writes what was asked for and says what was found, after `notes` on the log; an experiment that
    /// was aborted is a fault. One that was shown is shown until somebody has seen enough.
    pub(super) fn conclude(
        self,
        scenario: &Scenario,
        recording: Recording,
        outcome: Outcome,
        notes: Notes,
    ) -> Result<(), Fault> {
        let Notes {
            agreement,
            logs,
            predictions,
        } = notes;
        let agreement = agreement.as_ref();
        let Recorded {
            summary,
            traces,
            rows,
            live,
        } = recording.finish(scenario, outcome);
        let picture = self.plot.zip(traces.as_ref());
        let document = Document::new(&summary, agreement).of_logs(logs, predictions);
        let page = traces.as_ref().map(|traces| {
            page::experiment(&Experiment {
                title: &self.title,
                command: &call::command(),
                scenario,
                summary: &summary,
                document: &document,
                agreement,
                traces,
            })
        });
        files::commit([
            rows.map(Rows::finish),
            picture.map(|(picture, traces)| {
                picture.panels("", 2, &panels::experiment(&summary, traces))
            }),
            self.report
                .zip(page.as_ref())
                .map(|(report, page)| report.page(page)),
            self.json.map(|json| json.document(&document)),
        ])?;
        if !self.silent {
            for log in &document.logs {
                say!("{log}")?;
            }
            if let Some(agreement) = agreement {
                let warning = if agreement.holds() { "" } else { "warning: " };
                say!("{warning}{agreement}")?;
            }
            say!("{}", table::estimates(&[(summary.law, &summary)]))?;
            let truth = summary.truth.map(|_| &scenario.effects);
            let terms = terms::terms(&summary, truth);
            if !terms.is_empty() {
                say!("{terms}")?;
            }
            say!("{}: {}", summary.status().name(), summary.reason)?;
            if let Some(batch) = &summary.batch {
                say!(
                    "{}",
                    residual::Words {
                        batch,
                        cause: summary.cause()
                    }
                )?;
            }
            for prediction in &document.predictions {
                say!("{prediction}")?;
            }
        }
        if let (Some(live), Some(page)) = (live, &page) {
            live.stay(page);
        }
        match summary.status() {
            Status::Aborted => Err(Fault::Other(summary.reason)),
            _ => Ok(()),
        }
    }
}
