//! Sentences on logs: how one is taken, and what a replay found.

use std::fmt;
use std::path::Path;

use identifier_log::recognise::Finding;
use identifier_log::result::{LogReading, Prediction};

/// A log and how it is taken.
#[must_use]
pub fn introduction(log: &Path, findings: &[Finding]) -> String {
    let lines = findings.iter();
    let lines: Vec<_> = lines
        .map(|finding| format!("  {:9}  {}", finding.about, finding.text))
        .collect();
    format!("{} is read as\n{}", log.display(), lines.join("\n"))
}

/// A sentence on one of them.
#[derive(Debug)]
pub(super) struct Sentence<'a, T>(pub(super) &'a T);

impl fmt::Display for Sentence<'_, LogReading> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Jitter that text and rounding leave, part of a sample.
        const ROUNDED: f64 = 5e-3;
        write!(
            f,
            "{}: {} samples at {} Hz",
            self.0.file,
            self.0.samples,
            short(1.0 / self.0.sample_time)
        )?;
        if self.0.jitter_max > ROUNDED {
            write!(
                f,
                "; time stamps jitter by {:.1} % of a sample rms, {:.0} % at most, and are treated as even",
                100.0 * self.0.jitter_rms,
                100.0 * self.0.jitter_max
            )?;
        }
        if self.0.bridged_samples > 0 {
            write!(
                f,
                "; {} missing samples in {} gaps were interpolated linearly",
                self.0.bridged_samples, self.0.gaps
            )?;
        }
        if self.0.left_out_rows > 0 {
            write!(f, "; {} rows were left out", self.0.left_out_rows)?;
        }
        for (count, what) in [
            (self.0.spikes, "positions far from those before and after"),
            (self.0.damaged_lines, "lines of another width"),
        ] {
            if count > 0 {
                write!(f, "; left out: {count} {what}")?;
            }
        }
        if let Some(separator) = self.0.separator
            && (separator != "comma" || self.0.decimal_commas)
        {
            let commas = if self.0.decimal_commas {
                " and decimal commas"
            } else {
                ""
            };
            write!(f, "; read with {separator}s between columns{commas}")?;
        }
        if let Some(period) = self.0.wrapped {
            write!(
                f,
                "; its position wraps every {} {} and was unwrapped",
                short(period),
                self.0.unit.name()
            )?;
        }
        self.0
            .notes
            .iter()
            .try_for_each(|note| write!(f, "; {note}"))
    }
}

/// A number of six digits, without zeros at its end.
fn short(number: f64) -> f64 {
    let size = 10_f64.powf(5.0 - number.abs().log10().floor());
    (number * size).round() / size
}

impl fmt::Display for Sentence<'_, Prediction> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "prediction of {}", self.0.file)?;
        if self.0.learnt_from {
            write!(f, " (a log of the fit)")?;
        }
        match &self.0.closed_loop {
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
                ": no closed loop (it needs a declared controller and log.reference, and must stay within bounds)"
            )?,
        }
        match &self.0.open_loop {
            Some(found) => write!(
                f,
                "; open-loop simulation from a fitted start, position {:.4} {unit} rms, {:.4} {unit} at most ({:.2} %)",
                found.rms,
                found.max,
                100.0 * found.relative,
                unit = found.unit
            ),
            None => write!(
                f,
                "; no open-loop simulation (it needs log.command, and must stay within bounds)"
            ),
        }
    }
}
