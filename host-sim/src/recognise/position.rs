//! The unit of a position and the encoder behind it.

use std::f64::consts::TAU;

use std::path::Path;

use super::columns::Chosen;
use super::name::Unit;
use super::{Question, Stated};
use crate::log::{Jumps, LogError, Period, Table, TableColumn};
use crate::scan::{Positions, is_usual, is_whole};
use crate::scenario::{LogUnits, PositionUnit};

/// The unit of a position, and its encoder where the steps show one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    pub(super) unit: PositionUnit,
    /// The evidence for the unit.
    pub(super) evidence: &'static str,
    /// Counts of a revolution.
    pub(super) counts_per_rev: Option<f64>,
    /// Smallest step, column units, where positions have steps.
    pub(super) step: Option<f64>,
}

/// Angles that a position may be in, those of fewer counts first.
const ANGLES: [PositionUnit; 3] = [
    PositionUnit::Turn,
    PositionUnit::Degree,
    PositionUnit::Radian,
];

/// Reads the unit of a column.
///
/// # Errors
/// The question, where neither name nor content shows the unit, or the counts of a revolution.
pub(super) fn read(
    column: &TableColumn,
    chosen: &Chosen,
    stated: &Stated,
) -> Result<Reading, Question> {
    let step = Positions::of(column.held().into_iter()).and_then(|positions| positions.step());
    let (unit, evidence) = unit(column, chosen, stated, step).ok_or_else(|| {
        let steps = match step {
            Some(step) => format!("its steps of {} do not show it", short(step)),
            None => "neither its name nor its numbers show it".to_owned(),
        };
        Question {
            flag: "position-unit",
            text: format!(
                "the unit of {} is not known, as {steps}: state rad, deg, turns, counts, m or mm",
                chosen.column
            ),
        }
    })?;
    let counts_per_rev = match (stated.counts_per_rev, unit) {
        (Some(counts), _) => Some(counts),
        (None, PositionUnit::Count) => {
            return Err(Question {
                flag: "counts-per-rev",
                text: format!(
                    "{} is in counts: state how many a revolution has, after fourfold evaluation",
                    chosen.column
                ),
            });
        }
        (None, PositionUnit::Metre | PositionUnit::Millimetre) => None,
        (None, angle) => {
            let scale = stated.position_scale.unwrap_or(1.0).abs();
            let radians = scale * LogUnits::SI.radians(angle);
            step.map(|step| TAU / (step * radians))
                .filter(|counts| is_whole(*counts))
                .map(f64::round)
        }
    };
    Ok(Reading {
        unit,
        evidence,
        counts_per_rev,
        step,
    })
}

/// Checks that a position has no spikes: single rows far from those before and behind.
///
/// # Errors
/// How many there are, and where the first is.
pub(super) fn check(path: &Path, table: &Table, chosen: &Chosen) -> Result<(), LogError> {
    /// Size of a spike, steps of the quicker motion, and the part of them that is quicker.
    const SIZE: f64 = 10.0;
    const QUICKER: usize = 10;
    let positions = table.columns[chosen.index].continued();
    let steps: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut sizes: Vec<f64> = steps.iter().map(|step| step.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let usual = sizes[sizes.len() - 1 - sizes.len() / QUICKER];
    let is_spike =
        |pair: &[f64]| pair[0] * pair[1] < 0.0 && pair[0].abs().min(pair[1].abs()) > SIZE * usual;
    let spikes: Vec<usize> = (steps.windows(2).zip(2..))
        .filter(|(pair, _)| usual > 0.0 && is_spike(pair))
        .map(|(_, sample)| sample)
        .collect();
    let Some(first) = spikes.first() else {
        return Ok(());
    };
    let fault = format!(
        "column {} has {} in its first {} samples, the first in sample {first}, far from the samples before and behind: \
         they are no motion; look at the wires of the encoder, and take them out",
        chosen.column,
        match spikes.len() {
            1 => "a spike".to_owned(),
            count => format!("{count} spikes"),
        },
        table.rows
    );
    Err(LogError::of_file(path, &fault))
}

/// The unit with its evidence; none where nothing shows it.
fn unit(
    column: &TableColumn,
    chosen: &Chosen,
    stated: &Stated,
    step: Option<f64>,
) -> Option<(PositionUnit, &'static str)> {
    if let Some(unit) = stated.position_unit {
        return Some((unit, "as stated"));
    }
    if let Some(Unit::Position(unit)) = chosen.named.unit {
        return Some((unit, "by its name"));
    }
    if let Some(unit) = by_period(column, stated) {
        return Some((unit, "as it begins again after a revolution"));
    }
    let step = step?;
    let is_integer = step > 0.5 && (step - step.round()).abs() < 1e-3 * step;
    let is_one_of = |counts: f64, unit: &PositionUnit| {
        let count = TAU / counts / LogUnits::SI.radians(*unit);
        (step / count - 1.0).abs() < 1e-3
    };
    if let Some(counts) = stated.counts_per_rev.filter(|counts| *counts > 0.0) {
        let evidence = "as its steps are the counts of the encoder";
        let unit = ANGLES.iter().find(|unit| is_one_of(counts, unit)).copied();
        return unit
            .or(is_integer.then_some(PositionUnit::Count))
            .map(|unit| (unit, evidence));
    }
    if is_integer {
        return Some((PositionUnit::Count, "as its numbers are whole"));
    }
    if Positions::is_decimal(step) {
        return None;
    }
    let counts = |unit: &PositionUnit| TAU / (step * LogUnits::SI.radians(*unit));
    let unit = ANGLES.into_iter().find(|unit| is_usual(counts(unit)))?;
    Some((unit, "as its steps are those of an encoder"))
}

/// The unit of positions that begin again after a revolution.
fn by_period(column: &TableColumn, stated: &Stated) -> Option<PositionUnit> {
    let mut jumps = Jumps::default();
    let positions = column.held();
    for (place, position) in positions.iter().enumerate() {
        jumps.add(*position, place == 0);
    }
    let (low, high) = crate::log::extremes(&positions);
    let units = LogUnits {
        counts_per_rev: stated.counts_per_rev,
        ..LogUnits::SI
    };
    match jumps.period(high - low, &units)? {
        Period::Known(_) => Some(PositionUnit::Radian),
        Period::OfUnit(unit) => Some(unit),
        Period::Unknown(_) => None,
    }
}

/// Four figures.
pub(super) fn short(number: f64) -> String {
    let text = format!("{number:.3e}");
    text.parse()
        .map_or(text, |rounded: f64| rounded.to_string())
}
