//! The outputs of a result without a trace.

use std::path::{Path, PathBuf};

use super::drawing::Drawing;
use super::fault::Fault;
use super::files::{Files, Output, Picture};

/// Where it goes.
#[derive(Debug, clap::Args)]
pub(super) struct Documents {
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    drawing: Drawing,
    /// Write a report, one HTML page with everything in it, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Replace existing files.
    #[arg(long)]
    force: bool,
}

/// The files that are asked for, begun.
#[derive(Debug)]
pub(super) struct Begun {
    pub(super) files: Files,
    pub(super) json: Option<Output>,
    pub(super) picture: Option<Picture>,
    pub(super) page: Option<Output>,
}

impl Documents {
    /// Begins every file that is asked for, none of which may be among those that are read.
    ///
    /// # Errors
    /// A place where nothing can be written.
    pub(super) fn begin(&self, inputs: &[&Path]) -> Result<Begun, Fault> {
        let mut files = Files::reading(inputs, self.force);
        Ok(Begun {
            json: files.output(self.json.as_deref())?,
            picture: files.picture(&self.drawing)?,
            page: files.output(self.report.as_deref())?,
            files,
        })
    }
}
