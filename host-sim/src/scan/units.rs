//! The unit of the position, by the encoder that is declared, by the steps of the positions, by the column's name and
//! by the reference.

use std::f64::consts::TAU;

use super::grid::Positions;
use super::remark::{Remark, RemarkKind};
use crate::log::Log;
use crate::scenario::{Column, LogQuantity, PositionUnit, Scenario};

/// Units that a position is mistaken for, and those of a linear axis.
const ANGLES: [PositionUnit; 4] = [
    PositionUnit::Radian,
    PositionUnit::Degree,
    PositionUnit::Turn,
    PositionUnit::Count,
];

/// Ratios of the units of a position: degrees, turns and rad, mm and m.
pub(super) const RATIOS: [f64; 4] = [360.0 / TAU, TAU, 360.0, 1000.0];

/// The finding about the unit of the position, if there is one.
pub(super) fn position(scenario: &Scenario, log: &Log) -> Option<Remark> {
    let name = by_name(log);
    let units = &log.settings().units;
    let column = units.scale(LogQuantity::Position, log.sample_time).abs();
    let all = log.segments().iter().flat_map(|segment| &segment.positions);
    let Some(positions) = Positions::of(all.map(|position| position / column)) else {
        return name;
    };
    let found = match scenario.counts_per_rev {
        Some(counts) => with_encoder(counts, &positions, log, column),
        None => without_encoder(&positions, log),
    };
    found.or(name)
}

/// A name of the position's column that contradicts its unit.
fn by_name(log: &Log) -> Option<Remark> {
    let Column::Named(name) = &log.settings().position else {
        return None;
    };
    let own = log.settings().units.position;
    let words = name.split(|c: char| !c.is_alphabetic() && c != '°');
    let named = words.filter_map(PositionUnit::of_word).next_back()?;
    // Of a linear axis rad means m, and a scale makes a unit of any other.
    let is_scaled = !is_one(log.settings().units.position_scale.abs());
    if [own, PositionUnit::Metre].contains(&named) || is_scaled {
        return None;
    }
    let (named, own) = (named.name(), own.name());
    Some(Remark::refusing(
        RemarkKind::PositionUnit,
        format!(
            "the column {name} seems to be in {named}, and log.position_unit is \"{own}\": state log.position_unit = \
             \"{named}\", or log.position by the column's number if it is in {own}"
        ),
    ))
}

/// Positions beside the counts of the declared encoder.
fn with_encoder(counts: f64, positions: &Positions, log: &Log, column: f64) -> Option<Remark> {
    /// Factors by which counts are mistaken.
    const COARSER: [u32; 17] = [
        1024, 1000, 512, 256, 128, 100, 64, 50, 32, 20, 16, 10, 8, 5, 4, 3, 2,
    ];
    const FINER: [u32; 8] = [2, 4, 8, 16, 32, 64, 100, 10];
    let units = &log.settings().units;
    let count = TAU / counts / column;
    let own = units.position.name();
    let other_counts = |found: f64, what: String| {
        let text = format!(
            "{what}: state encoder.counts_per_rev = {found}, after fourfold evaluation, or the log.position_unit, which \
             is \"{own}\", if the encoder is as declared"
        );
        Remark::refusing(RemarkKind::CountsPerRev, text)
    };
    if positions.lie_on(count) {
        let factor = COARSER
            .into_iter()
            .find(|by| positions.lie_on(f64::from(*by) * count))?;
        let what =
            format!("the positions are multiples of {factor} counts of the declared encoder");
        return Some(other_counts(counts / f64::from(factor), what));
    }
    let step = positions.step();
    let in_other = |unit: &&PositionUnit| {
        let count = TAU / counts / (units.radians(**unit) * units.position_scale.abs());
        **unit != units.position && step.is_some_and(|step| is_one(step / count))
    };
    if let Some(unit) = ANGLES.iter().find(in_other) {
        let unit = unit.name();
        return Some(Remark::refusing(
            RemarkKind::PositionUnit,
            format!(
                "the positions lie on the counts of the declared encoder if they are in {unit}, and not in {own}: state \
                 log.position_unit = \"{unit}\""
            ),
        ));
    }
    let Some(step) = step else {
        return Some(Remark::noting(
            RemarkKind::CountsPerRev,
            "the positions have no steps, so that they are not those of the declared encoder: state \
             encoder.counts_per_rev = 0, or another column as log.position",
        ));
    };
    if let Some(factor) = FINER
        .into_iter()
        .find(|by| is_one(f64::from(*by) * step / count))
    {
        let what = format!("the positions have steps of 1/{factor} count of the declared encoder");
        return Some(other_counts(counts * f64::from(factor), what));
    }
    let found = TAU / (step * column);
    let what = format!(
        "the positions have steps of {} {own}, and a count of the declared encoder is {}",
        short(step),
        short(count)
    );
    if is_whole(found) {
        return Some(other_counts(found.round(), what));
    }
    Some(Remark::noting(
        RemarkKind::CountsPerRev,
        format!(
            "{what}: if the log rounds them, record more decimals; otherwise state encoder.counts_per_rev = {}, or \
             another log.position_unit",
            found.round()
        ),
    ))
}

/// Positions whose encoder is not declared: an encoder has a whole number of counts per revolution.
fn without_encoder(positions: &Positions, log: &Log) -> Option<Remark> {
    let units = &log.settings().units;
    let own = units.position;
    if !is_one(units.position_scale.abs()) || !ANGLES.contains(&own) {
        return None;
    }
    let step = positions.step()?;
    let counts = |unit: &PositionUnit| match unit {
        PositionUnit::Count => None,
        unit => Some(TAU / (step * units.radians(*unit))),
    };
    if counts(&own).is_some_and(is_whole) {
        return None;
    }
    let is_integer = step > 0.5 && is_one(step / step.round());
    if is_integer && own != PositionUnit::Count {
        return Some(Remark::refusing(
            RemarkKind::PositionUnit,
            format!(
                "the positions are whole numbers, as counts are, and log.position_unit is \"{}\": state \
                 log.position_unit = \"counts\" and encoder.counts_per_rev",
                own.name()
            ),
        ));
    }
    // Those of fewer counts first: whole in turns is whole in degrees, too.
    let units = [
        PositionUnit::Turn,
        PositionUnit::Degree,
        PositionUnit::Radian,
    ];
    let others: Vec<_> = (units.iter().filter(|unit| **unit != own))
        .filter_map(|unit| {
            Some((
                unit.name(),
                counts(unit).filter(|found| is_usual(*found))?.round(),
            ))
        })
        .collect();
    let (unit, found) = *others.first()?;
    let own = own.name();
    if Positions::is_decimal(step) {
        let others: Vec<_> = (others.iter())
            .map(|(unit, found)| format!("log.position_unit = \"{unit}\" if they are in {unit} ({found} counts per revolution)"))
            .collect();
        return Some(Remark::noting(
            RemarkKind::PositionUnit,
            format!(
                "the positions have steps of {} and are taken to be in {own}, rounded by the log: state {}, else \
                 encoder.counts_per_rev",
                short(step),
                others.join(", ")
            ),
        ));
    }
    Some(Remark::refusing(
        RemarkKind::PositionUnit,
        format!(
            "the positions have steps of {}, those of an encoder of {found} counts per revolution if they are in {unit}, \
             and of no encoder in {own}: state log.position_unit = \"{unit}\", or encoder.counts_per_rev",
            short(step)
        ),
    ))
}

/// The reference beside the position, which follows it.
pub(super) fn reference(log: &Log) -> Option<Remark> {
    /// Correlation from which the position follows its reference, and from which it does so closely.
    const MIN_CORRELATION: f64 = 0.5;
    const CLOSE: f64 = 0.9;
    /// Its reference over a position that a loop of some use leaves behind.
    const SLOW: f64 = 10.0;
    /// The part of its reference that a position covers, which is less where the loop is slow, more where it overshoots.
    const COVERED: std::ops::Range<f64> = 0.5..1.4;
    let (mut count, mut sums, mut squares, mut products) = (0.0, [0.0; 2], [0.0; 2], 0.0);
    for segment in log.segments() {
        let origin = [*segment.positions.first()?, *segment.references.first()?];
        for pair in segment.positions.iter().zip(&segment.references) {
            let (q, r) = (pair.0 - origin[0], pair.1 - origin[1]);
            count += 1.0;
            sums = [sums[0] + q, sums[1] + r];
            squares = [squares[0] + q * q, squares[1] + r * r];
            products += q * r;
        }
    }
    let product = products - sums[0] * sums[1] / count;
    let [position, reference] = [0, 1].map(|i: usize| squares[i] - sums[i] * sums[i] / count);
    let correlation = product / (position * reference).sqrt();
    if !correlation.is_finite() || correlation.abs() < MIN_CORRELATION {
        return None;
    }
    let ratio = (position / reference).sqrt();
    let differs = RATIOS.iter().any(|by| {
        // A slow loop covers a sixth of its reference, but not closely.
        let may_be_slow = *by < SLOW && correlation.abs() < CLOSE;
        COVERED.contains(&(ratio / by)) || !may_be_slow && COVERED.contains(&(ratio * by))
    });
    let text = match (differs, correlation < 0.0) {
        (true, _) => format!(
            "the position is {} times its reference: state the units of both, log.position_unit and log.reference_unit",
            short(ratio)
        ),
        (_, true) => "the position goes against its reference: state log.position_scale = -1, or \
                      log.reference_scale = -1"
            .to_owned(),
        _ => return None,
    };
    Some(Remark::refusing(RemarkKind::ReferenceUnit, text))
}

/// True for a ratio that is one, but for the rounding of a step.
fn is_one(ratio: f64) -> bool {
    (ratio - 1.0).abs() < 1e-3
}

/// True for a number of counts that is whole, as that of an encoder is, and not by chance.
pub(crate) fn is_whole(counts: f64) -> bool {
    const MAX_DISTANCE: f64 = 0.02;
    (20.0..1e7).contains(&counts) && (counts - counts.round()).abs() < MAX_DISTANCE
}

/// True for a number of counts that encoders have: a product of twos and fives, and threes twice at most.
pub(crate) fn is_usual(counts: f64) -> bool {
    if !is_whole(counts) {
        return false;
    }
    let mut rest = counts.round() as u64;
    for (factor, times) in [(2, 32), (5, 5), (3, 2)] {
        for _ in 0..times {
            if rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
    }
    rest == 1
}

/// Four figures.
fn short(number: f64) -> String {
    let text = format!("{number:.3e}");
    text.parse()
        .map_or(text, |rounded: f64| rounded.to_string())
}
