//! The outputs of one experiment.

use std::path::{Path, PathBuf};

use super::call;
use super::drawing::Drawing;
use super::fault::Fault;
use super::files::{self, Files, Output, Picture, io_error};
use super::live::{Live, LiveOptions};
use super::live_experiment::LiveExperiment;
use super::recording::{Messages, Recorded, Recording, Rows};
use super::reproduce;
use super::standard_output::say;
use super::terminal::width;
use crate::analysis::Status;
use crate::experiment::Outcome;
use crate::log::mcap::trace;
use crate::present::traces::{self, Traces};
use crate::present::{self, Experiment};
use crate::provenance::{Kept, Origin, OriginAlone, WithOrigin};
use crate::render::terminal;
use crate::report::csv::TraceWriter;
use crate::result::ReplayNotes;
use crate::scenario::Scenario;

/// Where the results of one experiment go.
#[derive(Debug, clap::Args)]
pub(super) struct Outputs {
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write the trace, one row per sample, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Write the trace and its provenance to this MCAP file, for Foxglove and PlotJuggler; `-` is standard
    /// output.
    #[arg(long, value_name = "FILE")]
    pub(super) mcap: Option<PathBuf>,
    #[command(flatten)]
    pub(super) drawing: Drawing,
    /// Write a report, one HTML page with everything in it, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    pub(super) report: Option<PathBuf>,
    #[command(flatten)]
    pub(super) live: LiveOptions,
    /// Replace existing files.
    #[arg(long)]
    pub(super) force: bool,
}

/// The results of one experiment, begun.
#[derive(Debug)]
pub(super) struct Results {
    /// What the report is called.
    title: String,
    json: Option<Output>,
    csv: Option<Output>,
    /// What is said beside a trace in CSV of where it is from.
    description: Option<Output>,
    mcap: Option<Output>,
    plot: Option<Picture>,
    report: Option<Output>,
    live: Option<Live>,
    /// Whether one of them has standard output to itself.
    silent: bool,
    origin: Origin,
    /// What is to be had again.
    kept: Option<Kept>,
}

impl Outputs {
    /// Begins every file that is asked for, none of which may be among those that are read; the report has
    /// a `title`. They say of what `origin` they are; the result is to be the one that was `kept`, if one
    /// was.
    pub(super) fn begin(
        &self,
        title: String,
        inputs: &[&Path],
        origin: Origin,
        kept: Option<&Kept>,
    ) -> Result<Results, Fault> {
        let mut files = Files::reading(inputs, self.force);
        Ok(Results {
            title,
            json: files.output(self.json.as_deref())?,
            csv: files.output(self.csv.as_deref())?,
            description: files.description_of(self.csv.as_deref())?,
            mcap: files.output(self.mcap.as_deref())?,
            plot: files.picture(&self.drawing)?,
            report: files.output(self.report.as_deref())?,
            live: self.live.begin()?,
            silent: files.own_standard_output(),
            origin,
            kept: kept.cloned(),
        })
    }

    /// Whether anything is written that says where it is from.
    pub(super) fn tell_origin(&self) -> bool {
        self.json.is_some() || self.csv.is_some() || self.mcap.is_some()
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
        let is_shown = self.plot.is_some() || self.report.is_some() || self.live.is_some();
        let traces = is_shown.then(Traces::default);
        let live = self.live.take();
        let live = live.map(|live| LiveExperiment::new(live, &self.title, scenario, duration));
        Recording::new(scenario, duration, passes, rows, messages, traces, live)
    }

    /// Writes what was asked for and says what was found, after `notes` on the log; an experiment that
    /// was aborted is a fault. One that was shown is shown until somebody has seen enough.
    pub(super) fn conclude(
        self,
        scenario: &Scenario,
        recording: Recording,
        outcome: Outcome,
        notes: ReplayNotes,
    ) -> Result<(), Fault> {
        let Recorded {
            mut summary,
            traces,
            rows,
            messages,
            live,
        } = recording.finish(scenario, outcome);
        summary.replay = notes;
        let picture = self.plot.zip(traces.as_ref());
        let page = present::experiment(&Experiment {
            title: &self.title,
            command: &call::command(),
            scenario,
            summary: &summary,
            traces: traces.as_ref(),
        });
        let told = WithOrigin {
            result: &summary,
            origin: &self.origin,
        };
        files::commit([
            rows.map(|rows| rows.finish(TraceWriter::finish)),
            self.description
                .map(|description| description.document(&OriginAlone::of(&self.origin))),
            messages.map(|messages| {
                messages.finish(|mut messages| {
                    messages.about("result", Origin::entry(&summary)?)?;
                    messages.finish()
                })
            }),
            picture.map(|(picture, traces)| {
                picture.figures("", 2, &traces::figures(&summary, traces))
            }),
            self.report.map(|report| report.page(&page)),
            self.json.map(|json| json.document(&told)),
        ])?;
        if !self.silent {
            say!("{}", terminal::brief(&page, width()))?;
            say!("{}", terminal::verdict(&page))?;
        }
        if let Some(kept) = &self.kept {
            reproduce::compare(kept, &summary, self.silent)?;
        }
        if let Some(live) = live {
            live.stay(&page);
        }
        match summary.status() {
            Status::Aborted => Err(Fault::Other(summary.reason)),
            _ => Ok(()),
        }
    }
}
