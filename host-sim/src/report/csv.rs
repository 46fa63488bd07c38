//! Traces as comma-separated values, one row a sample, SI.

use std::io::Write;

use crate::experiment::Sample;

/// Names and units of the columns.
const COLUMNS: [&str; 13] = [
    "time_s",
    "reference_rad",
    "position_rad",
    "command",
    "output_error_rad",
    "a_per_s",
    "b_rad_per_s2_per_command",
    "coulomb_rad_per_s2",
    "load_rad_per_s2",
    "a_std_error",
    "b_std_error",
    "coulomb_std_error",
    "load_std_error",
];

/// Writes a trace. What a law does not have is left empty.
///
/// # Errors
/// Whatever the writer answers.
pub fn write(out: impl Write, trace: &[Sample]) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(COLUMNS)?;
    for sample in trace {
        let known = |value: f64| {
            if value.is_finite() {
                value.to_string()
            } else {
                String::new()
            }
        };
        let optional = |value: Option<f64>| value.map_or_else(String::new, |x| x.to_string());
        writer.write_record([
            sample.time.to_string(),
            known(sample.reference),
            sample.position.to_string(),
            sample.command.to_string(),
            optional(sample.output_error),
            known(sample.estimates.a),
            known(sample.estimates.b),
            known(sample.estimates.coulomb),
            known(sample.estimates.load),
            optional(sample.standard_errors.map(|errors| errors.a)),
            optional(sample.standard_errors.map(|errors| errors.b)),
            optional(sample.standard_errors.map(|errors| errors.coulomb)),
            optional(sample.standard_errors.map(|errors| errors.load)),
        ])?;
    }
    writer.flush()?;
    Ok(())
}
