//! The time of a log: it must advance evenly; gaps are bridged where that is allowed.

use std::path::Path;

use super::rows::{LogError, Record, Rows};

/// How far a step of time may be from the sample time and count as one, relative.
const JITTER: f64 = 0.01;

/// The records of a log in even time, one at a time.
pub(super) struct Records<'a> {
    path: &'a Path,
    rows: Rows<'a>,
    /// The name of the column of time.
    column: &'a str,
    sample_time: f64,
    /// The most missing samples in a row that may be bridged.
    bridge: u32,
    last: Option<Record>,
    gap: Option<Gap>,
}

/// A gap that is being bridged.
#[derive(Debug, Clone, Copy)]
struct Gap {
    from: Record,
    to: Record,
    missing: u32,
    bridged: u32,
}

impl<'a> Records<'a> {
    pub(super) fn new(
        path: &'a Path,
        rows: Rows<'a>,
        column: &'a str,
        sample_time: f64,
        bridge: u32,
    ) -> Self {
        Self {
            path,
            rows,
            column,
            sample_time,
            bridge,
            last: None,
            gap: None,
        }
    }

    /// How many samples are missing between two rows.
    fn missing(&self, last: &Record, next: &Record) -> Result<u32, String> {
        let sample_time = self.sample_time;
        let step = next.time - last.time;
        let steps = step / sample_time;
        let whole = steps.round();
        if step <= 0.0 {
            return Err(format!(
                "time goes from {} to {} s: it must advance by the sample time, {sample_time} s",
                last.time, next.time
            ));
        }
        let even = (steps - whole).abs() <= JITTER * whole.max(1.0) && whole >= 1.0;
        if !even {
            return Err(format!(
                "time advances by {step:.9} s: it must advance by the sample time, {sample_time} s, \
                 to {} %",
                100.0 * JITTER
            ));
        }
        let missing = whole - 1.0;
        if missing > f64::from(self.bridge) {
            return Err(format!(
                "{missing} samples are missing before {} s: at most {} may be bridged (set \
                 log.bridge_gaps to allow more)",
                next.time, self.bridge
            ));
        }
        Ok(missing as u32)
    }

    /// The next row, or the first sample of the bridge to it.
    fn after(&mut self, next: Record) -> Result<Record, LogError> {
        if let Some(from) = self.last.replace(next) {
            let missing = self.missing(&from, &next).map_err(|fault| {
                LogError::of_line(self.path, next.line, Some(self.column), fault)
            })?;
            self.gap = (missing > 0).then_some(Gap {
                from,
                to: next,
                missing,
                bridged: 0,
            });
        }
        Ok(self.cross().unwrap_or(next))
    }

    /// The next sample of the gap that is being bridged, the row behind it at last.
    fn cross(&mut self) -> Option<Record> {
        let gap = self.gap.as_mut()?;
        gap.bridged += 1;
        if gap.bridged > gap.missing {
            let to = gap.to;
            self.gap = None;
            return Some(to);
        }
        let Gap {
            from,
            to,
            missing,
            bridged,
        } = *gap;
        let part = f64::from(bridged) / f64::from(missing + 1);
        let between = |from: f64, to: f64| from + part * (to - from);
        let both = |from: Option<f64>, to: Option<f64>| Some(between(from?, to?));
        Some(Record {
            line: to.line,
            time: between(from.time, to.time),
            reference: both(from.reference, to.reference),
            position: between(from.position, to.position),
            command: both(from.command, to.command),
            injection: between(from.injection, to.injection),
            bridged: true,
        })
    }
}

impl Iterator for Records<'_> {
    type Item = Result<Record, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(record) = self.cross() {
            return Some(Ok(record));
        }
        let row = self.rows.next()?;
        Some(row.and_then(|row| self.after(row)))
    }
}

/// The sample time of a log that nobody states, s: the middle one of its first steps, made exact over
/// the whole length.
///
/// # Errors
/// Whatever is wrong with a row.
pub(super) fn usual_step(rows: Rows<'_>) -> Result<Option<f64>, LogError> {
    /// Steps that are looked at: their middle does not become truer by more.
    const STEPS: usize = 100_000;
    let mut steps = Vec::new();
    let mut ends: Option<(f64, f64)> = None;
    for row in rows {
        let time = row?.time;
        if let Some((_, last)) = ends
            && steps.len() < STEPS
        {
            steps.push(time - last);
        }
        ends = Some((ends.map_or(time, |(first, _)| first), time));
    }
    let (Some((first, last)), false) = (ends, steps.is_empty()) else {
        return Ok(None);
    };
    steps.sort_by(f64::total_cmp);
    let middle = steps[steps.len() / 2];
    let whole = last - first;
    let count = (whole / middle).round();
    Ok(Some(if count >= 1.0 { whole / count } else { middle }))
}
