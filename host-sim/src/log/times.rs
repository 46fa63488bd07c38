//! The time stamps of a whole log, before its sample time is stated.

use std::path::Path;

use super::LogError;
use super::file::Format;
use super::row::Rows;
use crate::scenario::LogSettings;

/// The time stamps of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Times {
    /// Its rows.
    pub rows: u64,
    /// Median of the times from one row to the next, s; NaN where no stamp advances.
    pub step: f64,
    /// First and last stamp, s.
    pub ends: [f64; 2],
    /// Rows with the stamp of the row before.
    pub still: u64,
    /// Rows with an earlier stamp than the row before.
    pub back: u64,
    /// The gaps, the first ones of many.
    pub gaps: Vec<Gap>,
    /// All gaps.
    pub gap_count: u64,
}

/// A gap in the stamps of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// The stamps before and behind it, s.
    pub between: [f64; 2],
    /// Samples that are missing.
    pub missing: u64,
}

impl Times {
    /// Most gaps that are kept.
    const MAX_GAPS: usize = 256;

    /// Reads the whole file for its stamps.
    ///
    /// # Errors
    /// The row that cannot be read.
    pub fn read(path: &Path, settings: &LogSettings) -> Result<Self, LogError> {
        /// A step of this many usual ones has a sample missing.
        const MIN_GAP: f64 = 1.6;
        let format = Format::detect(path)?;
        let rows = || format.open(path, settings, f64::NAN);
        let step = median_step(rows()?)?;
        let mut times = Self {
            step,
            ..Self::default()
        };
        let mut last: Option<f64> = None;
        for row in rows()? {
            let time = row?.time;
            times.rows += 1;
            let Some(before) = last.replace(time) else {
                times.ends[0] = time;
                continue;
            };
            times.ends[1] = time;
            let passed = time - before;
            times.still += u64::from(passed == 0.0);
            times.back += u64::from(passed < 0.0);
            if passed > MIN_GAP * step {
                times.gap_count += 1;
                if times.gaps.len() < Self::MAX_GAPS {
                    times.gaps.push(Gap {
                        between: [before, time],
                        missing: ((passed / step).round() as u64).saturating_sub(1),
                    });
                }
            }
        }
        Ok(times)
    }
}

/// Median of the first times from one row to the next that advance, s; NaN where none does.
fn median_step(rows: Box<dyn Rows + '_>) -> Result<f64, LogError> {
    /// Steps that are examined.
    const MAX_STEPS: usize = 100_000;
    let mut steps = Vec::new();
    let mut last = f64::NAN;
    for row in rows {
        let time = row?.time;
        steps.extend(Some(time - last).filter(|step| *step > 0.0));
        last = time;
        if steps.len() == MAX_STEPS {
            break;
        }
    }
    steps.sort_unstable_by(f64::total_cmp);
    Ok(steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN))
}
