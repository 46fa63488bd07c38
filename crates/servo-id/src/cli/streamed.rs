//! A file that is written while an experiment runs.

use std::io;

use super::fault::Fault;
use super::output_file::Output;

/// A file that is written sample by sample. The first failure ends the writing and is reported at the end: an
/// experiment is not stopped for a full disk.
#[derive(Debug)]
pub(super) struct Streamed<W> {
    /// The file's name.
    name: String,
    writer: io::Result<W>,
}

impl<W> Streamed<W> {
    /// Begins a file.
    pub(super) fn begin(output: Output, begin: impl FnOnce(Output) -> io::Result<W>) -> Self {
        Self {
            name: output.name().display().to_string(),
            writer: begin(output),
        }
    }

    /// Writes a part.
    pub(super) fn write(&mut self, write: impl FnOnce(&mut W) -> io::Result<()>) {
        if let Ok(writer) = &mut self.writer
            && let Err(error) = write(writer)
        {
            self.writer = Err(error);
        }
    }

    /// Ends the file.
    ///
    /// # Errors
    /// The first failure of its writing.
    pub(super) fn finish(
        self,
        finish: impl FnOnce(W) -> io::Result<Output>,
    ) -> Result<Output, Fault> {
        self.writer
            .and_then(finish)
            .map_err(|error| Fault::unwritable(&self.name, &error))
    }
}
