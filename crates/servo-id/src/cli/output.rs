//! The outputs of a verb: options, files begun before the work, and their completion after it.

use std::path::{Path, PathBuf};

use identifier_log::provenance::{Origin, WithOrigin};
use serde::Serialize;

use super::fault::Fault;
use super::files::{self, Drawing, Files, Picture};
use super::output_file::Output;
use super::standard_output::show;
use super::terminal::width;
use crate::present::Page;
use crate::render::terminal;

/// The output options of a verb with a result.
#[derive(Debug, clap::Args)]
pub(super) struct Documents {
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a report, one self-contained HTML page, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Replace what this program did not write, too.
    #[arg(long)]
    force: bool,
}

/// The output options of one experiment.
#[derive(Debug, clap::Args)]
pub(super) struct Outputs {
    #[command(flatten)]
    documents: Documents,
    #[command(flatten)]
    drawing: Drawing,
    /// Write the trace, one row per sample, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// The requested outputs of a verb, begun.
#[derive(Debug)]
pub(super) struct Results {
    pub(super) csv: Option<Output>,
    /// The scenario of the result, where it is to be saved.
    scenario: Option<Result<Output, Fault>>,
    files: Files,
    json: Option<Output>,
    plot: Option<Picture>,
    report: Option<Output>,
    provenance: Option<Provenance>,
}

/// Provenance of an experiment's result.
#[derive(Debug)]
struct Provenance {
    origin: Origin,
    /// The description beside a trace in CSV, which holds the origin.
    description: Option<Output>,
}

impl Documents {
    /// Begins every requested file, a picture and a table in CSV among them; none may be among the `inputs`.
    ///
    /// # Errors
    /// A place where nothing can be written.
    pub(super) fn begin(
        &self,
        inputs: &[&Path],
        drawing: &Drawing,
        csv: Option<&Path>,
    ) -> Result<Results, Fault> {
        let mut files = Files::reading(inputs, self.force);
        Ok(Results {
            json: files.output(self.json.as_deref())?,
            plot: files.picture(drawing)?,
            report: files.output(self.report.as_deref())?,
            csv: files.output(csv)?,
            scenario: None,
            provenance: None,
            files,
        })
    }
}

impl Outputs {
    /// Begins every requested file, none of which may be among the `inputs`, with the `origin` of the result.
    ///
    /// # Errors
    /// A place where nothing can be written.
    pub(super) fn begin(&self, inputs: &[&Path], origin: Origin) -> Result<Results, Fault> {
        let csv = self.csv.as_deref();
        let mut results = self.documents.begin(inputs, &self.drawing, csv)?;
        results.provenance = Some(Provenance {
            origin,
            description: results.files.description_of(csv)?,
        });
        Ok(results)
    }
}

impl Results {
    /// True if one of them has standard output to itself.
    pub(super) fn own_standard_output(&self) -> bool {
        self.files.own_standard_output()
    }

    /// True if traces are shown in a picture or a page.
    pub(super) fn show_traces(&self) -> bool {
        self.plot.is_some() || self.report.is_some()
    }

    /// Keeps the text of a scenario for a file, which is completed with the results.
    ///
    /// # Errors
    /// A place where nothing can be written.
    pub(super) fn save_scenario(&mut self, file: Option<&Path>, text: &str) -> Result<(), Fault> {
        let output = self.files.output(file)?;
        self.scenario = output.map(|mut output| {
            output.bytes(text.as_bytes())?;
            Ok(output)
        });
        Ok(())
    }

    /// Completes every file, those that were `written` already among them, and prints the page in brief, perhaps
    /// with its verdict. A picture has so many columns.
    ///
    /// # Errors
    /// A file that could not be written completely; then none is.
    pub(super) fn publish(
        self,
        page: &Page,
        columns: usize,
        with_verdict: bool,
        result: &impl Serialize,
        written: impl IntoIterator<Item = Option<Result<Output, Fault>>>,
    ) -> Result<(), Fault> {
        let silent = self.own_standard_output();
        let (origin, description) = match self.provenance {
            Some(known) => (Some(known.origin), known.description),
            None => (None, None),
        };
        let origin = origin.as_ref();
        let own = [
            description.zip(origin).map(|(description, origin)| {
                let result = None::<&()>;
                description.document(&WithOrigin { result, origin })
            }),
            self.plot.map(|plot| plot.figures("", columns, page)),
            self.report.map(|report| report.page(page)),
            self.json.map(|json| match origin {
                Some(origin) => {
                    let result = Some(result);
                    json.document(&WithOrigin { result, origin })
                }
                None => json.document(result),
            }),
        ];
        let files = files::commit(written.into_iter().chain([self.scenario]).chain(own))?;
        if !silent {
            if !files.is_empty() {
                let names = files.iter().map(|file| file.display().to_string());
                let names: Vec<_> = names.collect();
                show!("Written: {}", names.join(", "))?;
            }
            show!("{}", terminal::brief(page, width()))?;
            if with_verdict {
                show!("{}", terminal::verdict(page))?;
            }
        }
        Ok(())
    }
}
