//! Traces as comma-separated values, one row a sample, SI.

use std::fmt::Write as _;
use std::io::{self, Write};

use crate::experiment::Sample;
use crate::log::mcap::trace;

/// Writes a trace row by row; its columns are the fields of an MCAP trace.
#[derive(Debug)]
pub struct TraceWriter<W: Write> {
    rows: csv::Writer<W>,
    field: String,
}

impl<W: Write> TraceWriter<W> {
    /// Begins with the heading.
    ///
    /// # Errors
    /// Whatever the writer answers.
    pub fn new(out: W) -> Result<Self, csv::Error> {
        let mut rows = csv::Writer::from_writer(out);
        let fields = trace::SERVO.fields.iter().chain(trace::ESTIMATES.fields);
        rows.write_record(fields.map(|(name, _)| name))?;
        Ok(Self {
            rows,
            field: String::new(),
        })
    }

    /// Writes a sample. What a law does not have is left empty, and so is what is not finite.
    ///
    /// # Errors
    /// Whatever the writer answers.
    pub fn add(&mut self, sample: &Sample) -> Result<(), csv::Error> {
        for value in sample.measured().into_iter().chain(sample.identified()) {
            self.field.clear();
            if let Some(value) = value.filter(|value| value.is_finite()) {
                // Nothing can fail that is written into memory.
                let _ = write!(self.field, "{value}");
            }
            self.rows.write_field(&self.field)?;
        }
        self.rows.write_record(None::<&[u8]>)
    }

    /// Ends the file; what it was written into comes back.
    ///
    /// # Errors
    /// Whatever the writer answers.
    pub fn finish(self) -> io::Result<W> {
        let out = self.rows.into_inner();
        out.map_err(csv::IntoInnerError::into_error)
    }
}

/// Writes a trace.
///
/// # Errors
/// Whatever the writer answers.
pub fn write(out: impl Write, trace: &[Sample]) -> Result<(), csv::Error> {
    let mut writer = TraceWriter::new(out)?;
    for sample in trace {
        writer.add(sample)?;
    }
    writer.finish()?;
    Ok(())
}
