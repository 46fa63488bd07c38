//! The unit of time and the sample time of a log.

use super::columns::Chosen;
use super::name::{Quantity, Unit};
use super::{Question, Stated};
use crate::log::{Table, Times};
use crate::scenario::TimeUnit;

/// The unit of a column of time, with the evidence.
///
/// # Errors
/// The question, where more than one unit or none is likely.
pub(super) fn unit(
    table: &Table,
    time: &Chosen,
    stated: &Stated,
) -> Result<(TimeUnit, &'static str), Question> {
    if let Some(unit) = stated.time_unit {
        return Ok((unit, "as stated"));
    }
    let column = &table.columns[time.index];
    if column.stamps > column.numbers {
        return Ok((TimeUnit::Stamp, "by its stamps"));
    }
    if let Some(Unit::Time(unit)) = time.named.unit {
        return Ok((unit, "by its name"));
    }
    let step = usual_step(&column.values);
    if time.named.quantity == Quantity::Counter && is_one(step) {
        return Ok((TimeUnit::Sample, "by its name"));
    }
    let likely = likely_units(step);
    match likely[..] {
        [unit] => Ok((unit, "as its steps are those of a servo's loop")),
        _ => Err(Question {
            flag: "time-unit",
            text: format!(
                "the unit of {} is not known: its steps are {step}, state s, ms, us, ns, or samples for a counter",
                time.column
            ),
        }),
    }
}

/// The units in which a step may be the sample time of a servo's loop.
fn likely_units(step: f64) -> Vec<TimeUnit> {
    /// Sample times of servo loops and of their logs, s.
    const LIKELY: std::ops::RangeInclusive<f64> = 2e-5..=0.05;
    let all = TimeUnit::ALL.iter().copied();
    let mut likely: Vec<_> = all
        .filter(|unit| *unit != TimeUnit::Stamp)
        .filter(|unit| (unit.seconds()).is_some_and(|of| LIKELY.contains(&(of * step))))
        .collect();
    if is_one(step) {
        likely.push(TimeUnit::Sample);
    }
    likely
}

/// True for the step of a counter.
fn is_one(step: f64) -> bool {
    (step - 1.0).abs() < 1e-6
}

/// The median of the steps that advance.
fn usual_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let mut steps: Vec<_> = steps.filter(|step| *step > 0.0).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN);
    // To six digits: a stamp is not exact.
    format!("{median:.5e}").parse().unwrap_or(median)
}

/// How a log's stamps are taken.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Spacing {
    /// Its rows are the samples, and stamps with missing samples between them are bridged or left out.
    Stamped {
        /// The most samples that straight lines bridge.
        bridge: u32,
        /// The ranges that are left out, s.
        cut: Vec<[f64; 2]>,
    },
    /// The stamps are too coarse: the rows are samples of this length, s.
    Coarse(f64),
    /// The stamps go back from row to row.
    Backwards,
    /// They do not advance at all.
    Still,
    /// Rows are missing all over, this share of them.
    Lossy(f64),
}

/// How the stamps of a log are taken.
pub(super) fn spacing(times: &Times) -> Spacing {
    /// Longest gap that straight lines bridge, samples, and the part of the samples that may be bridged.
    const MAX_BRIDGED: u64 = 3;
    const MAX_SHARE: f64 = 0.01;
    /// Part of the rows with the stamp before from which stamps are too coarse.
    const COARSE: f64 = 0.2;
    /// Gaps that are left out; of more the reader says where the first is.
    const MAX_CUTS: usize = 64;
    /// Share of the steps from which gaps are no exception.
    const LOSSY: f64 = 0.02;
    if times.step.is_nan() && times.back == 0 {
        return Spacing::Still;
    }
    if times.back * 2 > times.rows {
        return Spacing::Backwards;
    }
    if times.back == 0 && times.still as f64 > COARSE * times.rows as f64 {
        let [first, last] = times.ends;
        return Spacing::Coarse((last - first) / (times.rows.max(2) - 1) as f64);
    }
    let lossy = times.gap_count as f64 / times.rows as f64;
    if lossy > LOSSY {
        return Spacing::Lossy(lossy);
    }
    let has_all = times.gap_count == times.gaps.len() as u64;
    let short: u64 = (times.gaps.iter().map(|gap| gap.missing))
        .filter(|missing| *missing <= MAX_BRIDGED)
        .sum();
    let few = short as f64 <= MAX_SHARE * times.rows as f64 && has_all;
    let bridge = if few && short > 0 { MAX_BRIDGED } else { 0 };
    let long = times.gaps.iter().filter(|gap| gap.missing > bridge);
    let cut: Vec<_> = long
        .map(|gap| {
            let [from, to] = gap.between;
            let quarter = 0.25 * (to - from);
            [from + quarter, to - quarter]
        })
        .collect();
    let cut = match cut.len() <= MAX_CUTS && has_all {
        true => cut,
        false => Vec::new(),
    };
    Spacing::Stamped {
        bridge: bridge as u32,
        cut,
    }
}
