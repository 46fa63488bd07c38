//! What is written of one experiment.

use std::path::{Path, PathBuf};

use super::fault::Fault;
use super::files::{self, Files, Output, Picture};
use super::standard_output::say;
use crate::experiment::Sample;
use crate::replay::Agreement;
use crate::report::json::Document;
use crate::report::residual::Report;
use crate::report::{Status, Summary, csv, panels, table};
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
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

/// The results of one experiment, begun.
#[derive(Debug)]
pub(super) struct Results {
    json: Option<Output>,
    csv: Option<Output>,
    plot: Option<Picture>,
    /// Whether one of them has standard output to itself.
    silent: bool,
}

/// What there is to be said of a log.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// How well the declared controller reproduces the recorded command.
    pub(super) agreement: Option<Agreement>,
    /// How many samples were bridged.
    pub(super) bridged: Option<String>,
}

impl Outputs {
    /// Begins every file that is asked for, none of which may be among those that are read.
    pub(super) fn begin(&self, inputs: &[&Path]) -> Result<Results, Fault> {
        let mut files = Files::reading(inputs, self.force);
        Ok(Results {
            json: files.output(self.json.as_deref())?,
            csv: files.output(self.csv.as_deref())?,
            plot: files.picture(self.plot.as_deref())?,
            silent: files.own_standard_output(),
        })
    }
}

impl Results {
    /// Writes what was asked for and says what was found, after `notes` on the log; an experiment that
    /// was aborted is a fault.
    pub(super) fn conclude(
        self,
        scenario: &Scenario,
        summary: Summary,
        trace: &[Sample],
        notes: &Notes,
    ) -> Result<(), Fault> {
        let residual = summary
            .output_error
            .map(|_| Report::new(scenario, &summary, trace));
        let silent = self.silent;
        self.write(&summary, trace, residual.as_ref(), notes)?;
        if !silent {
            if let Some(agreement) = &notes.agreement {
                let warning = if agreement.holds() { "" } else { "warning: " };
                say!("{warning}{agreement}")?;
            }
            if let Some(bridged) = &notes.bridged {
                say!("{bridged}")?;
            }
            say!("{}", table::estimates(&[(summary.law, &summary)]))?;
            say!("{}: {}", summary.status.name(), summary.reason)?;
            if let Some(residual) = residual {
                say!("{residual}")?;
            }
        }
        match summary.status {
            Status::Aborted => Err(Fault::Other(summary.reason)),
            Status::Converged | Status::NotConverged => Ok(()),
        }
    }

    fn write(
        self,
        summary: &Summary,
        trace: &[Sample],
        residual: Option<&Report>,
        notes: &Notes,
    ) -> Result<(), Fault> {
        let Self {
            json, csv, plot, ..
        } = self;
        let document = || Document::new(summary, residual, notes.agreement.as_ref());
        files::commit([
            csv.map(|csv| csv.table(|file| csv::write(file, trace))),
            plot.map(|plot| plot.panels("", 2, &panels::experiment(summary, trace))),
            json.map(|json| json.document(&document())),
        ])
    }
}
