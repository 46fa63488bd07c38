//! The time of a log: one sample after the other, gaps bridged where that is allowed.

use std::path::Path;

use super::clock::{Clock, Jitter, Tick};
use super::error::{LogError, rounded};
use super::row::{Row, Rows};
use super::wrap::Unwrap;
use crate::scenario::{LogSettings, TimeUnit};

/// The rows of a log in even time, one at a time.
pub(super) struct EvenRows<'a> {
    path: &'a Path,
    rows: Box<dyn Rows + 'a>,
    settings: &'a LogSettings,
    sample_time: f64,
    last: Option<(Row, Clock)>,
    gap: Option<Gap>,
    spacing: Spacing,
    /// Continues positions that begin again after a period.
    unwrap: Option<Unwrap>,
    /// True if the reference begins again with them.
    reference_wraps: bool,
}

/// Measured spacing of a log's rows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Spacing {
    /// Of all stretches but the one that is being read.
    jitter: Jitter,
    /// Time that rows cover without those left out, s, and its samples.
    time: f64,
    samples: f64,
}

/// Positions of a log that begin again after a period, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrapped {
    /// The period.
    pub period: f64,
    /// True if the reference begins again, too.
    pub reference_too: bool,
}

/// A gap that is being bridged.
#[derive(Debug, Clone, Copy)]
struct Gap {
    from: Row,
    to: Row,
    missing: u32,
    bridged: u32,
}

impl<'a> EvenRows<'a> {
    pub(super) fn new(
        path: &'a Path,
        rows: Box<dyn Rows + 'a>,
        settings: &'a LogSettings,
        sample_time: f64,
    ) -> Self {
        Self {
            path,
            rows,
            settings,
            sample_time,
            last: None,
            gap: None,
            spacing: Spacing::default(),
            unwrap: None,
            reference_wraps: false,
        }
    }

    /// The same, positions continued where they begin again after a period.
    pub(super) fn unwrapping(mut self, wrap: Option<&Wrapped>) -> Self {
        self.unwrap = wrap.map(|wrap| Unwrap::new(wrap.period));
        self.reference_wraps = wrap.is_some_and(|wrap| wrap.reference_too);
        self
    }

    /// Continues position and reference of a row.
    fn unwrap(&mut self, row: &mut Row) {
        let Some(unwrap) = &mut self.unwrap else {
            return;
        };
        row.position = unwrap.position(row.position);
        if self.reference_wraps {
            row.reference =
                (row.reference).map(|reference| unwrap.reference(reference, row.position));
        }
    }

    /// Their source.
    pub(super) fn source(&self) -> &dyn Rows {
        self.rows.as_ref()
    }

    /// Deviation of the stamps from an even clock.
    pub(super) fn jitter(&self) -> Jitter {
        let now = self.last.map(|(_, clock)| clock.jitter());
        self.spacing.jitter.with(now.unwrap_or_default())
    }

    /// The mean time from one sample to the next, s, over what was read.
    pub(super) fn mean_step(&self) -> Option<f64> {
        let Spacing { time, samples, .. } = self.spacing;
        (samples > 0.0).then(|| time / samples)
    }

    /// The next row, or the first sample of the bridge to it.
    fn after(&mut self, mut next: Row) -> Result<Row, LogError> {
        let is_cut = |last: &Row| {
            next.time > last.time && self.settings.leaves_out_between(last.time, next.time)
        };
        let Some((from, mut clock)) = self.last.filter(|(last, _)| !is_cut(last)) else {
            self.spacing.jitter = self.jitter();
            next.begins = true;
            self.last = Some((next, Clock::new(self.sample_time, next.time)));
            return Ok(next);
        };
        let missing = self
            .missing(clock.tick(next.time), &from, &next)
            .map_err(|fault| {
                let column = self.settings.time.as_ref().map(ToString::to_string);
                LogError::at_line(self.path, next.line, column.as_deref(), fault)
            })?;
        self.spacing.time += next.time - from.time;
        self.spacing.samples += f64::from(missing) + 1.0;
        self.last = Some((next, clock));
        self.gap = (missing > 0).then_some(Gap {
            from,
            to: next,
            missing,
            bridged: 0,
        });
        Ok(self.cross().unwrap_or(next))
    }

    /// The number of samples that are missing before a row.
    fn missing(&self, tick: Tick, from: &Row, next: &Row) -> Result<u32, String> {
        let sample_time = rounded(self.sample_time);
        let step = rounded(next.time - from.time);
        let [before, now] = [from.time, next.time].map(rounded);
        let so_far = || match self.mean_step() {
            Some(mean) => format!(" (so far {} s on average)", rounded(mean)),
            None => String::new(),
        };
        match tick {
            Tick::After(samples) if samples - 1 <= self.settings.bridge => Ok(samples - 1),
            Tick::After(samples) => Err(format!(
                "{} missing before {now} s, as a sample time is {sample_time} s{}: at most {} may be \
                 bridged (set log.bridge_gaps to allow more, or leave the gap out with log.cut)",
                match samples - 1 {
                    1 => "1 sample is".to_owned(),
                    missing => format!("{missing} samples are"),
                },
                so_far(),
                self.settings.bridge
            )),
            Tick::Back => Err(format!(
                "time goes from {before} to {now} s: it must advance from row to row; leave the range \
                 out with log.cut{}",
                self.without_time()
            )),
            Tick::TooEarly => Err(format!(
                "time advances by {step} s{}: it must advance by the sample time, {sample_time} s, \
                 to half of it",
                so_far()
            )),
        }
    }

    /// The remedy for stamps that are too coarse.
    fn without_time(&self) -> &'static str {
        match self.settings.units.time {
            TimeUnit::Sample => "",
            _ => ", or if the stamps are too coarse state log.sample_time and no log.time",
        }
    }

    /// The next sample of the gap that is being bridged, the row behind it at last.
    fn cross(&mut self) -> Option<Row> {
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
        Some(Row {
            line: to.line,
            time: between(from.time, to.time),
            reference: both(from.reference, to.reference),
            position: between(from.position, to.position),
            command: both(from.command, to.command),
            injection: between(from.injection, to.injection),
            velocity: both(from.velocity, to.velocity),
            bridged: true,
            begins: false,
        })
    }
}

impl Iterator for EvenRows<'_> {
    type Item = Result<Row, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(record) = self.cross() {
            return Some(Ok(record));
        }
        let row = self.rows.next()?;
        Some(row.and_then(|mut row| {
            self.unwrap(&mut row);
            self.after(row)
        }))
    }
}

/// The sample time of a log where none is stated, s, from the steps of its first rows: the mean of those
/// without a missing sample, or, where stamps are too coarse to find them, of all.
///
/// # Errors
/// The fault of a row.
pub(super) fn usual_step(
    rows: Box<dyn Rows + '_>,
    settings: &LogSettings,
) -> Result<Option<f64>, LogError> {
    /// Steps that are examined.
    const MAX_STEPS: usize = 100_000;
    /// A step of this many medians has a sample missing.
    const MIN_GAP: f64 = 1.5;
    /// Largest share of gaps among the steps.
    const MAX_GAP_SHARE: f64 = 0.1;
    let mut steps = Vec::new();
    let mut last: Option<f64> = None;
    for row in rows {
        let time = row?.time;
        if let Some(last) = last
            && time > last
            && !settings.leaves_out_between(last, time)
        {
            steps.push(time - last);
        }
        last = Some(time);
        if steps.len() == MAX_STEPS {
            break;
        }
    }
    if steps.is_empty() {
        return Ok(None);
    }
    steps.sort_unstable_by(f64::total_cmp);
    let longest = MIN_GAP * steps[steps.len() / 2];
    let whole = steps.partition_point(|step| *step <= longest);
    let few = (steps.len() - whole) as f64 <= MAX_GAP_SHARE * steps.len() as f64;
    let counted = if few { &steps[..whole] } else { &steps };
    Ok(Some(counted.iter().sum::<f64>() / counted.len() as f64))
}
