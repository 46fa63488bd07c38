//! Traces as comma-separated values, one row a sample, SI.

use std::io::Write;

use crate::experiment::Sample;

/// Names and units of the columns.
const COLUMNS: [&str; 8] = [
    "time_s",
    "reference_rad",
    "position_rad",
    "command",
    "output_error_rad",
    "a_per_s",
    "b_rad_per_s2_per_command",
    "load_rad_per_s2",
];

/// Writes a trace. What a law does not have is left empty.
///
/// # Errors
/// Whatever the writer answers.
pub fn write(out: impl Write, trace: &[Sample]) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(COLUMNS)?;
    for sample in trace {
        let optional = |value: Option<f64>| value.map_or_else(String::new, |x| x.to_string());
        writer.write_record([
            sample.time.to_string(),
            sample.reference.to_string(),
            sample.position.to_string(),
            sample.command.to_string(),
            optional(sample.output_error),
            sample.a.to_string(),
            sample.b.to_string(),
            optional(sample.load),
        ])?;
    }
    writer.flush()?;
    Ok(())
}
