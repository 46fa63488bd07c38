//! The unit of a position and the encoder behind it.

use std::f64::consts::TAU;

use super::LogOptions;
use super::columns::Chosen;
use super::name::{self, Unit};
use crate::log::{Jumps, LogError, Period, Table, TableColumn};
use crate::readings::{Positions, held, is_usual, is_whole};
use crate::scenario::{LogUnits, PositionUnit};

/// The unit of a position, and its encoder where the steps show one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    /// True if rad denotes the column's own unit.
    pub(super) is_own: bool,
    /// Units for one of the column's.
    pub(super) scale: f64,
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

/// Reads the unit of a column. A unit that neither name nor content shows is the column's own. The result is in it, and
/// rad denotes one of it.
pub(super) fn read(
    column: &TableColumn,
    chosen: &Chosen,
    is_velocity: bool,
    stated: &LogOptions,
) -> Reading {
    if is_velocity && stated.position_unit.is_none() {
        let found = name::rate(&column.name, &column.unit);
        return Reading {
            is_own: found.is_none(),
            unit: PositionUnit::Radian,
            scale: found.map_or(1.0, |(_, scale)| scale),
            evidence: match found {
                Some(("rad/s", _)) => "per s, by name",
                Some(("rpm", _)) => "from rpm, by name",
                Some(("rev/s", _)) => "from revolutions per s, by name",
                Some(_) => "from degrees per s, by name",
                None => "unknown, read as rad: state --position-unit",
            },
            counts_per_rev: None,
            step: None,
        };
    }
    let values = column.values.iter().copied();
    let step = Positions::of(values.filter(|value| value.is_finite())).and_then(|of| of.step());
    let (unit, evidence) = match unit(column, chosen, stated, step) {
        Some((PositionUnit::Count, _)) if stated.counts_per_rev.is_none() => {
            return Reading {
                is_own: true,
                scale: 1.0,
                unit: PositionUnit::Radian,
                evidence: "of an encoder, read as rad: state --counts-per-rev",
                counts_per_rev: None,
                step,
            };
        }
        Some(found) => found,
        None => {
            return Reading {
                is_own: true,
                scale: 1.0,
                unit: PositionUnit::Radian,
                evidence: "unknown, read as rad: state --position-unit",
                counts_per_rev: None,
                step,
            };
        }
    };
    let counts_per_rev = match (stated.counts_per_rev, unit) {
        (Some(counts), _) => Some(counts),
        (None, PositionUnit::Count | PositionUnit::Metre | PositionUnit::Millimetre) => None,
        (None, angle) => {
            let scale = stated.position_scale.unwrap_or(1.0).abs();
            let radians = scale * LogUnits::SI.radians(angle);
            step.map(|step| TAU / (step * radians))
                .filter(|counts| is_whole(*counts))
                .map(f64::round)
        }
    };
    Reading {
        is_own: false,
        scale: 1.0,
        unit,
        evidence,
        counts_per_rev,
        step,
    }
}

impl Reading {
    /// The name of the unit.
    pub(super) fn name(&self) -> &'static str {
        match (self.is_own, self.evidence.starts_with("of")) {
            (true, true) => "counts",
            (true, false) => "a unit",
            (false, _) => self.unit.name(),
        }
    }
}

/// Checks that a position has no spikes: single rows far from those before and behind.
///
/// # Errors
/// How many there are, and where the first is.
pub(super) fn check(table: &Table, chosen: &Chosen) -> Result<(), LogError> {
    /// Size of a spike, steps of the quicker motion, and the part of them that is quicker.
    const SIZE: f64 = 10.0;
    const QUICKER: usize = 10;
    let positions = held(&table.columns[chosen.index].continued());
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
        "column {} has {} in its first {} samples, the first in sample {first}, far from the samples before and \
         after: this is no motion; check the encoder's wires and remove these samples",
        chosen.column,
        match spikes.len() {
            1 => "a spike".to_owned(),
            count => format!("{count} spikes"),
        },
        table.rows()
    );
    Err(LogError::of_file(&table.path, &fault))
}

/// The unit with its evidence; none where nothing shows it.
fn unit(
    column: &TableColumn,
    chosen: &Chosen,
    stated: &LogOptions,
    step: Option<f64>,
) -> Option<(PositionUnit, &'static str)> {
    if let Some(unit) = stated.position_unit {
        return Some((unit, "as stated"));
    }
    if let Some(Unit::Position(unit)) = chosen.named.unit {
        return Some((unit, "by name"));
    }
    if let Some(unit) = by_period(column, stated) {
        return Some((unit, "it wraps after a revolution"));
    }
    let step = step?;
    let is_integer = step > 0.5 && (step - step.round()).abs() < 1e-3 * step;
    let is_one_of = |counts: f64, unit: &PositionUnit| {
        let count = TAU / counts / LogUnits::SI.radians(*unit);
        (step / count - 1.0).abs() < 1e-3
    };
    if let Some(counts) = stated.counts_per_rev.filter(|counts| *counts > 0.0) {
        let evidence = "its steps are encoder counts";
        let unit = ANGLES.iter().find(|unit| is_one_of(counts, unit)).copied();
        return unit
            .or(is_integer.then_some(PositionUnit::Count))
            .map(|unit| (unit, evidence));
    }
    if is_integer {
        return Some((PositionUnit::Count, "all values are whole numbers"));
    }
    if Positions::is_decimal(step) {
        return None;
    }
    let counts = |unit: &PositionUnit| TAU / (step * LogUnits::SI.radians(*unit));
    let unit = ANGLES.into_iter().find(|unit| is_usual(counts(unit)))?;
    Some((unit, "its steps are those of a usual encoder"))
}

/// The unit of positions that begin again after a revolution.
fn by_period(column: &TableColumn, stated: &LogOptions) -> Option<PositionUnit> {
    let mut jumps = Jumps::default();
    let positions = held(&column.values);
    for (place, position) in positions.iter().enumerate() {
        jumps.add(*position, place == 0);
    }
    let (low, high) = crate::log::extremes(positions.iter().copied());
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
