//! A log in position units, as an identifier and a controller hear it.

use super::Record;
use crate::scenario::Scenario;

/// A sample of a log in position units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heard {
    /// As it is in the log.
    pub(super) record: Record,
    /// How far the position has moved since the last sample; nothing in the first.
    pub(super) increment: f64,
    /// How far it is from the reference; nothing where there is none.
    pub(super) error: f64,
}

/// Follows the position through a pass.
pub(super) struct Ear {
    first: f64,
    unit: f64,
    counts: bool,
    before: f64,
}

impl Ear {
    /// How near to a whole count a position must be to be that count, counts: what a few decimals of
    /// the log leave of it.
    const ON_COUNT: f64 = 0.01;

    /// For a log that begins at this position; positions that are counts of the scenario's encoder are
    /// made exactly that.
    pub(super) fn new(scenario: &Scenario, first: f64, unit: f64) -> Self {
        Self {
            first,
            unit,
            counts: scenario.counts_per_rev.is_some(),
            before: 0.0,
        }
    }

    pub(super) fn hear(&mut self, record: Record) -> Heard {
        let position = (record.position - self.first) / self.unit;
        let count = position.round();
        let is_count = self.counts && (position - count).abs() < Self::ON_COUNT;
        let position = if is_count { count } else { position };
        let increment = position - self.before;
        self.before = position;
        let reference = record.reference.unwrap_or(record.position);
        Heard {
            record,
            increment,
            error: (reference - record.position) / self.unit,
        }
    }
}
