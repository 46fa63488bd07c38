//! Positions that begin again after a revolution, 359°, 0°, or where a counter overflows.

use std::f64::consts::TAU;

use crate::scenario::{LogUnits, PositionUnit};

/// A step of the position with those beside it, all of the position's column, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    before: f64,
    here: f64,
    after: f64,
}

/// Gathers the largest steps of a position.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Jumps {
    /// The largest steps, at most [`Jumps::MAX_KEPT`].
    largest: Vec<Step>,
    /// The smallest step that is none of zero.
    smallest: Option<f64>,
    /// The last two positions and the step between those before.
    last: Option<f64>,
    step: Option<f64>,
    before: f64,
}

/// The period after which positions begin again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Period {
    /// SI, of the stated unit.
    Known(f64),
    /// That of positions in another unit than the stated one, column's units.
    OfUnit(PositionUnit, f64),
    /// Nothing that a position usually begins again after, column's units.
    Unknown(f64),
}

impl Jumps {
    const MAX_KEPT: usize = 32;

    /// The next position, `None` where the motion before is unknown.
    pub(crate) fn add(&mut self, position: f64, begins: bool) {
        if begins {
            self.complete(0.0);
            (self.last, self.step, self.before) = (Some(position), None, 0.0);
            return;
        }
        let here = position - self.last.unwrap_or(position);
        self.complete(here);
        (self.last, self.step) = (Some(position), Some(here));
    }

    /// Keeps the last step if it is one of the largest.
    fn complete(&mut self, after: f64) {
        let Some(here) = self.step else { return };
        let step = Step {
            before: self.before,
            here,
            after,
        };
        self.before = here;
        let size = here.abs();
        if size > 0.0 {
            self.smallest = Some(self.smallest.map_or(size, |smallest| smallest.min(size)));
        }
        if self.largest.len() < Self::MAX_KEPT {
            self.largest.push(step);
            return;
        }
        let smallest = (self.largest.iter_mut())
            .min_by(|one, other| one.here.abs().total_cmp(&other.here.abs()));
        if let Some(smallest) = smallest
            && smallest.here.abs() < step.here.abs()
        {
            *smallest = step;
        }
    }

    /// The period of positions that cover a `range`, SI, if they jump as if they began again.
    pub(crate) fn period(mut self, range: f64, units: &LogUnits) -> Option<Period> {
        /// Part of the range from which a step is a jump.
        const JUMP: f64 = 0.5;
        /// Part of the period by which the steps of a motion differ. Of a counter it is less, because periods of
        /// anything are near a power of two.
        const MARGIN: f64 = 0.02;
        const MARGIN_OF_COUNTER: f64 = 0.005;
        self.complete(0.0);
        let jumps: Vec<_> = (self.largest.into_iter())
            .filter(|step| step.here.abs() > JUMP * range)
            .collect();
        if jumps.is_empty() {
            return None;
        }
        let column = units
            .scale(crate::scenario::LogQuantity::Position, f64::NAN)
            .abs();
        let within = |margin: f64, period: f64| {
            range <= 1.001 * period && jumps.iter().all(|step| step.begins_again(period, margin))
        };
        let fits = |period: f64| within(MARGIN, period);
        let stated = match (units.position, units.counts_per_rev) {
            (PositionUnit::Metre | PositionUnit::Millimetre | PositionUnit::Own, _)
            | (PositionUnit::Count, None) => None,
            _ => [TAU, TAU * units.position_scale.abs()]
                .into_iter()
                .find(|period| fits(*period)),
        };
        if let Some(period) = stated {
            return Some(Period::Known(period));
        }
        // Counters of 8 bits and more.
        let counter = (8..=32)
            .map(|bits| 2_f64.powi(bits) * column)
            .find(|period| within(MARGIN_OF_COUNTER, *period));
        let of = [
            (PositionUnit::Degree, 360.0),
            (PositionUnit::Radian, TAU),
            (PositionUnit::Turn, 1.0),
        ];
        let other = of
            .into_iter()
            .find(|(unit, period)| *unit != units.position && fits(*period * column));
        match (units.position, counter, other, units.counts_per_rev) {
            (PositionUnit::Count, Some(period), ..) => Some(Period::Known(period)),
            (_, _, Some((unit, period)), _) => Some(Period::OfUnit(unit, period)),
            (_, Some(period), ..) => Some(Period::OfUnit(PositionUnit::Count, period / column)),
            (_, _, _, Some(counts)) if fits(counts * column) => {
                Some(Period::OfUnit(PositionUnit::Count, counts))
            }
            _ => Period::of_jumps(&jumps, range, self.smallest?)
                .map(|period| Period::Unknown(period / column)),
        }
    }
}

impl Step {
    /// True if the motion continues where the position begins again after a period, to a part of it.
    fn begins_again(&self, period: f64, margin: f64) -> bool {
        let continued = |step: f64| step - period * (step / period).round();
        let [before, here, after] = [self.before, self.here, self.after].map(continued);
        let (low, high) = (before.min(after), before.max(after));
        let margin = margin * period + 0.5 * (high - low);
        self.here.abs() > 0.5 * period && (low - margin..=high + margin).contains(&here)
    }
}

impl Period {
    /// The size that two or more jumps have in common, of positions whose `smallest` step is much smaller.
    fn of_jumps(jumps: &[Step], range: f64, smallest: f64) -> Option<f64> {
        /// Relative difference of jumps that are one size.
        const TOLERANCE: f64 = 0.02;
        /// Largest part of a jump that the steps beside it, and the smallest step, may have.
        const MAX_BESIDE: [f64; 2] = [0.2, 0.02];
        let largest = jumps
            .iter()
            .fold(0.0, |most, step| f64::max(most, step.here.abs()));
        // A jump beside a jump is where a position moves to and fro over the place at which it begins again.
        let continued = |step: f64| step - largest * (step / largest).round();
        let beside = |step: &Step| [step.before, step.after].map(continued);
        let of = |step: &Step| {
            let [before, after] = beside(step);
            (step.here - 0.5 * (before + after)).abs()
        };
        let size = jumps.iter().map(of).sum::<f64>() / jumps.len() as f64;
        let alike = jumps.iter().all(|step| {
            let [before, after] = beside(step).map(f64::abs);
            (of(step) / size - 1.0).abs() < TOLERANCE && before.max(after) < MAX_BESIDE[0] * size
        });
        // A spike goes forth and back.
        let is_alone = |step: &Step| step.before.abs().max(step.after.abs()) < MAX_BESIDE[0] * size;
        let is_jump = alike
            && jumps.iter().any(is_alone)
            && smallest < MAX_BESIDE[1] * size
            && range <= (1.0 + TOLERANCE) * size;
        (jumps.len() > 1 && is_jump).then_some(size)
    }
}

/// Continues a position, and the reference beside it, over the jumps of a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unwrap {
    period: f64,
    turns: f64,
    last: Option<f64>,
}

impl Unwrap {
    /// For a period, SI.
    pub(super) fn new(period: f64) -> Self {
        Self {
            period,
            turns: 0.0,
            last: None,
        }
    }

    /// The position continued from the last, by less than half a period.
    pub(super) fn position(&mut self, position: f64) -> f64 {
        let step = position - self.last.unwrap_or(position);
        self.turns -= (step / self.period).round();
        self.last = Some(position);
        position + self.turns * self.period
    }

    /// The reference that is nearest to a position that was continued.
    pub(super) fn reference(&self, reference: f64, position: f64) -> f64 {
        reference + self.period * ((position - reference) / self.period).round()
    }
}
