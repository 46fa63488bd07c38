//! What is written of one experiment.

use std::path::{Path, PathBuf};

use super::commission;
use super::fault::Fault;
use super::files::{self, Files, Output, Picture, io_error};
use super::recording::{Messages, Recorded, Recording, Rows};
use super::rerun;
use super::standard_output::say;
use crate::analysis::Status;
use crate::experiment::Outcome;
use crate::log_file::trace;
use crate::replay::Agreement;
use crate::report::csv::TraceWriter;
use crate::report::json::Document;
use crate::report::logs::{LogDocument, PredictionDocument};
use crate::report::panels::{self, Traces};
use crate::report::{residual, table, terms};
use crate::rerun::{Kept, Origin, OriginAlone, WithOrigin};
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
    /// Write the trace, with where it is from, to this MCAP file, which Foxglove and PlotJuggler show; `-` is
    /// standard output.
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    /// Draw the estimates and signals into this file, .png or .svg; `-` is standard output, as SVG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

/// The results of one experiment, begun.
#[derive(Debug)]
pub(super) struct Results {
    json: Option<Output>,
    csv: Option<Output>,
    /// What is said beside a trace in CSV of where it is from.
    description: Option<Output>,
    mcap: Option<Output>,
    plot: Option<Picture>,
    /// Whether one of them has standard output to itself.
    silent: bool,
    origin: Origin,
    /// What is to be had again.
    kept: Option<Kept>,
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
    /// Begins every file that is asked for, none of which may be among those that are read. They say of
    /// what `origin` they are; the result is to be the one that was `kept`, if one was.
    pub(super) fn begin(
        &self,
        inputs: &[&Path],
        origin: Origin,
        kept: Option<&Kept>,
    ) -> Result<Results, Fault> {
        let mut files = Files::reading(inputs, self.force);
        Ok(Results {
            json: files.output(self.json.as_deref())?,
            csv: files.output(self.csv.as_deref())?,
            description: files.description_of(self.csv.as_deref())?,
            mcap: files.output(self.mcap.as_deref())?,
            plot: files.picture(self.plot.as_deref())?,
            silent: files.own_standard_output(),
            origin,
            kept: kept.cloned(),
        })
    }

    /// Whether anything is written that says where it is from.
    pub(super) fn tell_origin(&self) -> bool {
        self.json.is_some() || self.csv.is_some() || self.mcap.is_some()
    }

    /// The same for a commissioning with this scenario.
    pub(super) fn of_commissioning(&self, scenario: &Path) -> commission::Arguments {
        commission::Arguments {
            scenario: scenario.to_owned(),
            port: None,
            json: self.json.clone(),
            csv: self.csv.clone(),
            mcap: self.mcap.clone(),
            plot: self.plot.clone(),
            force: self.force,
        }
    }
}

impl Results {
    /// What is kept of an experiment of so many passes while it runs; `duration` is that of all
    /// together, s.
    pub(super) fn record(&mut self, scenario: &Scenario, duration: f64, passes: u32) -> Recording {
        let rows = self.csv.take();
        let rows = rows.map(|csv| Rows::begin(csv, |csv| TraceWriter::new(csv).map_err(io_error)));
        let begin = |mcap| {
            let mut messages = trace::begin(mcap)?;
            messages.about("origin", self.origin.entries()?)?;
            Ok(messages)
        };
        let messages = self.mcap.take().map(|mcap| Messages::begin(mcap, begin));
        let traces = self.plot.is_some().then(Traces::default);
        Recording::new(scenario, duration, passes, rows, messages, traces)
    }

    /// Writes what was asked for and says what was found, after `notes` on the log; an experiment that
    /// was aborted is a fault.
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
            messages,
        } = recording.finish(scenario, outcome);
        let picture = self.plot.zip(traces);
        let document = Document::new(&summary, agreement).of_logs(logs, predictions);
        let told = WithOrigin {
            result: &document,
            origin: &self.origin,
        };
        files::commit([
            rows.map(|rows| rows.finish(TraceWriter::finish)),
            self.description
                .map(|description| description.document(&OriginAlone::of(&self.origin))),
            messages.map(|messages| {
                messages.finish(|mut messages| {
                    messages.about("result", Origin::entry(&document)?)?;
                    messages.finish()
                })
            }),
            picture.map(|(picture, traces)| {
                picture.panels("", 2, &panels::experiment(&summary, &traces))
            }),
            self.json.map(|json| json.document(&told)),
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
        if let Some(kept) = &self.kept {
            rerun::compare(kept, &document, self.silent)?;
        }
        match summary.status() {
            Status::Aborted => Err(Fault::Other(summary.reason)),
            _ => Ok(()),
        }
    }
}
