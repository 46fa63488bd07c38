//! Files that a verb writes.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::fault::Fault;
use super::recording::{Recorded, Recording, Rows};
use crate::analysis::Status;
use crate::experiment::{Outcome, Sample};
use crate::replay::Agreement;
use crate::report::json::Document;
use crate::report::panels::Traces;
use crate::report::{self, panels, plot, table};
use crate::scenario::Scenario;

/// The name that stands for standard output.
const STANDARD_OUTPUT: &str = "-";

/// Where the results of one experiment go.
#[derive(Debug, clap::Args)]
pub(super) struct Outputs {
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the trace, one row a sample, to this file.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the estimates and signals into this file, .png or .svg.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
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
    /// Whether every file can be asked for under its name.
    pub(super) fn check(&self) -> Result<(), Fault> {
        match &self.plot {
            Some(path) => Ok(plot::check_format(path)?),
            None => Ok(()),
        }
    }

    /// What is kept of an experiment of so many passes while it runs, each as long as the rest of them;
    /// `duration` is that of all, s.
    pub(super) fn begin(
        &self,
        scenario: &Scenario,
        duration: f64,
        passes: u32,
    ) -> Result<Recording, Fault> {
        let rows = self.csv.as_deref().map(Rows::create).transpose()?;
        let traces = self.plot.is_some().then(Traces::default);
        Ok(Recording::new(scenario, duration, passes, rows, traces))
    }

    /// Writes what was asked for and says what was found, after `notes` on the log; an experiment that
    /// was aborted is a fault.
    pub(super) fn conclude(
        &self,
        scenario: &Scenario,
        recording: Recording,
        outcome: Outcome,
        notes: &Notes,
    ) -> Result<(), Fault> {
        let Recorded {
            summary,
            residual,
            traces,
            rows,
        } = recording.finish(scenario, outcome);
        if let Some(rows) = rows {
            rows.finish()?;
        }
        if let (Some(path), Some(traces)) = (&self.plot, &traces) {
            plot::write(path, "", 2, &panels::experiment(&summary, traces))?;
        }
        if let Some(path) = &self.json {
            let agreement = notes.agreement.as_ref();
            document(path, &Document::new(&summary, residual.as_ref(), agreement))?;
        }
        if !is_standard_output(self.json.as_deref()) {
            if let Some(agreement) = &notes.agreement {
                let warning = if agreement.holds() { "" } else { "warning: " };
                say!("{warning}{agreement}");
            }
            if let Some(bridged) = &notes.bridged {
                say!("{bridged}");
            }
            say!("{}", table::estimates(&[(summary.law, &summary)]));
            say!("{}: {}", summary.status.name(), summary.reason);
            if let Some(residual) = residual {
                say!("{residual}");
            }
        }
        match summary.status {
            Status::Aborted => Err(Fault::Other(summary.reason)),
            Status::Converged | Status::NotConverged => Ok(()),
        }
    }
}

/// Whether a result goes to standard output, which then belongs to it alone.
pub(super) fn is_standard_output(path: Option<&Path>) -> bool {
    path.is_some_and(|path| path.as_os_str() == STANDARD_OUTPUT)
}

/// Writes a document as JSON to a file or to standard output.
pub(super) fn document(path: &Path, document: &impl Serialize) -> Result<(), Fault> {
    if is_standard_output(Some(path)) {
        let text = text(path, document)?;
        writeln!(io::stdout(), "{text}").map_err(|error| Fault::unwritable(path, error))
    } else {
        json(path, document)
    }
}

fn text(path: &Path, document: &impl Serialize) -> Result<String, Fault> {
    serde_json::to_string_pretty(document).map_err(|error| Fault::unwritable(path, error))
}

/// Writes a document as JSON to a file.
pub(super) fn json(path: &Path, document: &impl Serialize) -> Result<(), Fault> {
    let text = text(path, document)? + "\n";
    std::fs::write(path, text).map_err(|error| Fault::unwritable(path, error))
}

/// Writes a trace as CSV.
pub(super) fn csv(path: &Path, trace: &[Sample]) -> Result<(), Fault> {
    let file = File::create(path).map_err(|error| Fault::unwritable(path, error))?;
    report::csv::write(BufWriter::new(file), trace).map_err(|error| Fault::unwritable(path, error))
}
