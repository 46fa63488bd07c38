//! Sentences on the logs of a replay.

use std::fmt;

use crate::result::{LogReading, Prediction};

impl fmt::Display for LogReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Jitter that text and rounding leave, part of a sample.
        const ROUNDED: f64 = 5e-3;
        write!(
            f,
            "{}: {} samples at {} Hz",
            self.file,
            self.samples,
            short(1.0 / self.sample_time)
        )?;
        if self.jitter_max > ROUNDED {
            write!(
                f,
                "; their time stamps jitter by {:.1} % of a sample rms, {:.0} % at most, and count as even",
                100.0 * self.jitter_rms,
                100.0 * self.jitter_max
            )?;
        }
        if self.bridged_samples > 0 {
            write!(
                f,
                "; {} missing samples in {} gaps were bridged by straight lines",
                self.bridged_samples, self.gaps
            )?;
        }
        if self.left_out_rows > 0 {
            write!(f, "; {} rows were left out", self.left_out_rows)?;
        }
        if let Some(separator) = self.separator
            && (separator != "comma" || self.decimal_commas)
        {
            let commas = if self.decimal_commas {
                " and decimal commas"
            } else {
                ""
            };
            write!(f, "; read with {separator}s between columns{commas}")?;
        }
        if let Some(period) = self.wrapped {
            write!(
                f,
                "; its position begins again every {} rad and was continued",
                short(period)
            )?;
        }
        if let Some(units) = &self.units_row {
            write!(
                f,
                "; the row below the heading is no sample but units ({units})"
            )?;
        }
        Ok(())
    }
}

/// A number of six digits, without zeros at its end.
fn short(number: f64) -> f64 {
    let size = 10_f64.powf(5.0 - number.abs().log10().floor());
    (number * size).round() / size
}

impl fmt::Display for Prediction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "prediction of {}", self.file)?;
        if self.learnt_from {
            write!(f, " (which the estimates were learnt from)")?;
        }
        match &self.closed_loop {
            Some(found) => {
                let per_cent = |part: f64| format!("{:.3} %", 100.0 * part);
                write!(
                    f,
                    ": closed loop, position {}, velocity {}",
                    per_cent(found.position),
                    per_cent(found.velocity)
                )?;
                if let Some(command) = found.command {
                    write!(f, ", command {}", per_cent(command))?;
                }
            }
            None => write!(
                f,
                ": no closed loop (it takes a declared controller and log.reference, and must stay in \
                 bounds)"
            )?,
        }
        match &self.open_loop {
            Some(found) => write!(
                f,
                "; open loop from a fitted start, position {:.4} {unit} rms, {:.4} {unit} at most \
                 ({:.2} %)",
                found.rms,
                found.max,
                100.0 * found.relative,
                unit = found.unit
            ),
            None => write!(
                f,
                "; no open loop (it takes log.command, and must stay in bounds)"
            ),
        }
    }
}
