use std::io::{self, Write};

use crate::commission::Sample;
use crate::log::mcap::commissioning;

/// Writes the samples of a commissioning row by row, SI; its columns are the fields of the MCAP file. A
/// disabled servo has a command of zero; a reading that the encoder did not give is left empty.
#[derive(Debug)]
pub struct RowWriter<W: Write>(csv::Writer<W>);

impl<W: Write> RowWriter<W> {
    /// Begins with the heading.
    ///
    /// # Errors
    /// Whatever the writer answers.
    pub fn new(out: W) -> Result<Self, csv::Error> {
        let mut rows = csv::Writer::from_writer(out);
        rows.write_record(commissioning::SERVO.fields.iter().map(|(name, _)| name))?;
        Ok(Self(rows))
    }

    /// Writes a sample.
    ///
    /// # Errors
    /// Whatever the writer answers.
    pub fn add(&mut self, sample: &Sample) -> Result<(), csv::Error> {
        let known = |position: Option<f64>| position.map_or_else(String::new, |q| q.to_string());
        self.0.write_record([
            sample.time.to_string(),
            known(sample.reference),
            known(sample.measured),
            sample.command.unwrap_or(0.0).to_string(),
            sample.phase.name().to_owned(),
            sample.position.to_string(),
            sample.velocity.to_string(),
        ])
    }

    /// Ends the file; what it was written into comes back.
    ///
    /// # Errors
    /// Whatever the writer answers.
    pub fn finish(self) -> io::Result<W> {
        let out = self.0.into_inner();
        out.map_err(csv::IntoInnerError::into_error)
    }
}
