//! The unit of a position and the encoder behind it.

use std::f64::consts::TAU;

use super::LogOptions;
use super::name::Named;
use super::unit::Unit;
use crate::log::{Jumps, Period, TableColumn};
use crate::readings::{Positions, held, is_usual, is_whole};
use crate::scenario::{LogUnits, PositionUnit};

/// The unit of a position, and its encoder where the steps show one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PositionReading {
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

/// The evidence of a unit that nothing shows.
const UNSTATED: &str = "nobody states it: with --position-unit gravity goes by the angle";

const BY_NAME: &str = "by name";

/// Why a name leaves the unit open.
const fn open(named: Option<Unit>) -> &'static str {
    match named {
        Some(Unit::Electrical) => {
            "revolutions of the field, of which a shaft has so many as pairs of poles: --position-unit turns and \
             --position-scale of 1 over 60 times the pairs"
        }
        Some(Unit::Doubtful) => "the unit in its name is not known: --position-unit",
        _ => UNSTATED,
    }
}

/// Reads the unit of a column. A unit that neither name nor content shows is the column's own.
pub(super) fn read(
    column: &TableColumn,
    named: &Named,
    is_velocity: bool,
    stated: &LogOptions,
) -> PositionReading {
    let counts_per_rev = stated.counts_per_rev.filter(|counts| *counts != 0.0);
    if is_velocity && stated.position_unit.is_none() {
        let (unit, scale, evidence) = match named.unit {
            Some(Unit::Rate(unit, scale)) => (unit, scale, BY_NAME),
            of => (PositionUnit::Own, 1.0, open(of)),
        };
        return PositionReading {
            unit,
            scale,
            evidence,
            counts_per_rev,
            step: None,
        };
    }
    let values = column.values.iter().copied();
    let values = values.filter(|value| value.is_finite());
    let step = Positions::of(values.clone()).and_then(|of| of.step());
    let of_encoder = step.filter(|step| !is_rounding(values, *step));
    let period = period(column, stated);
    let found = unit(named, stated, of_encoder, period);
    let (unit, evidence) = found.unwrap_or((PositionUnit::Own, open(named.unit)));
    let part = match named.unit {
        Some(Unit::Position(_, part)) if evidence == BY_NAME => part,
        _ => 1.0,
    };
    let of_steps = || {
        let scale = part * stated.position_scale.unwrap_or(1.0).abs();
        let step = of_encoder.filter(|step| !Positions::is_decimal(*step))?;
        let counts = TAU / (step * scale * LogUnits::SI.radians(unit));
        is_whole(counts).then(|| counts.round())
    };
    PositionReading {
        scale: part,
        unit,
        evidence,
        counts_per_rev: counts_per_rev.or_else(|| match unit {
            PositionUnit::Count => period.and_then(|(_, period)| revolution(period)),
            PositionUnit::Degree | PositionUnit::Turn | PositionUnit::Radian => of_steps(),
            _ => None,
        }),
        step,
    }
}

/// True for a step that numbers of some bits have near the largest: smaller ones lie between its multiples, or there are none.
fn is_rounding(values: impl Iterator<Item = f64> + Clone, step: f64) -> bool {
    /// Bits of a number in single precision.
    const BITS: i32 = 24;
    let largest = values
        .clone()
        .fold(0.0, |most: f64, value| most.max(value.abs()));
    let small = values.filter(|value| value.abs() < 0.25 * largest);
    match Positions::of(small) {
        Some(small) => !small.lie_on(step),
        None => step < 1.5 * 2_f64.powf(largest.log2().floor()) * 2_f64.powi(1 - BITS),
    }
}

/// The counts of a revolution after which an absolute encoder begins again: a power of two, but not the width of a
/// register, which overflows anywhere.
fn revolution(period: f64) -> Option<f64> {
    const REGISTERS: [f64; 4] = [8.0, 16.0, 24.0, 32.0];
    let bits = period.log2();
    (bits.fract() == 0.0 && !REGISTERS.contains(&bits)).then_some(period)
}

impl PositionReading {
    /// The name of the unit.
    pub(super) fn name(&self) -> &'static str {
        match self.unit {
            PositionUnit::Own => "its own unit",
            unit => unit.name(),
        }
    }
}

/// The unit with its evidence; none where nothing shows it.
fn unit(
    named: &Named,
    stated: &LogOptions,
    step: Option<f64>,
    period: Option<(PositionUnit, f64)>,
) -> Option<(PositionUnit, &'static str)> {
    if let Some(unit) = stated.position_unit {
        return Some((unit, "as stated"));
    }
    if let Some(Unit::Position(unit, _)) = named.unit {
        return Some((unit, BY_NAME));
    }
    if let Some((unit, _)) = period {
        return Some(match unit {
            PositionUnit::Count => (unit, "it wraps at a power of two"),
            _ => (unit, "it wraps after a revolution"),
        });
    }
    let step = step?;
    let is_integer = step > 0.5 && (step - step.round()).abs() < 1e-3 * step;
    let is_one_of = |counts: f64, unit: &PositionUnit| {
        let count = TAU / counts / LogUnits::SI.radians(*unit);
        (step / count - 1.0).abs() < 1e-3
    };
    if let Some(counts) = stated.counts_per_rev.filter(|counts| *counts != 0.0) {
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
    let is_of_encoder = |unit: &PositionUnit| {
        let counts = TAU / (step * LogUnits::SI.radians(*unit));
        match unit {
            // A converter of 5 or 10 V has steps of 360° over nine times a power of two.
            PositionUnit::Degree => is_usual(counts) && counts.round() % 9.0 != 0.0,
            // Shares of a range have steps of one over a power of two.
            PositionUnit::Turn => {
                is_usual(counts) && (named.turns || !(counts.round() as u64).is_power_of_two())
            }
            _ => is_usual(counts),
        }
    };
    let unit = ANGLES.into_iter().find(is_of_encoder)?;
    Some((unit, "its steps are those of a usual encoder"))
}

/// The period of positions that begin again after a revolution, in the unit that it shows.
fn period(column: &TableColumn, stated: &LogOptions) -> Option<(PositionUnit, f64)> {
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
    let period = jumps
        .period(high - low, &units)
        .filter(|_| stated.wrap != Some(0.0));
    match period? {
        Period::Known(period) => Some((PositionUnit::Radian, period)),
        Period::OfUnit(unit, period) => Some((unit, period)),
        Period::Unknown(_) => None,
    }
}

/// Four figures.
pub(super) fn short(number: f64) -> String {
    let text = format!("{number:.3e}");
    text.parse()
        .map_or(text, |rounded: f64| rounded.to_string())
}
