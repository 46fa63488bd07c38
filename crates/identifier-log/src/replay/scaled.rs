//! The rows of a log in position units, as identifier and controller take them.

use crate::log::Row;
use crate::scenario::Options;

/// A row of a log in position units.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScaledRow {
    /// The row in the log's own form.
    pub(super) row: Row,
    /// Motion since the last sample; zero in the first.
    pub(super) increment: f64,
    /// Reference less position; zero where there is no reference.
    pub(super) error: f64,
}

/// Follows the position through a segment.
#[derive(Debug)]
pub(super) struct RowScaler {
    first: f64,
    unit: f64,
    counts: bool,
    before: f64,
    has_moved: bool,
}

impl RowScaler {
    /// Largest distance of a position from its count, counts. It covers rounding to a few decimals of the log.
    const MAX_ROUNDING: f64 = 0.01;

    /// Counts within which a drive takes its servo not to have moved. Until then its command may be another than its
    /// controller's: it grows slowly.
    const AT_REST: f64 = 4.0;

    /// For a segment that begins at this position. Positions within rounding of a count of the scenario's encoder
    /// become that count.
    pub(super) fn new(scenario: &Options, first: f64, unit: f64) -> Self {
        Self {
            first,
            unit,
            counts: scenario.counts_per_rev.is_some(),
            before: 0.0,
            has_moved: false,
        }
    }

    /// True if the servo has moved in the samples so far.
    pub(super) fn has_moved(&self) -> bool {
        self.has_moved
    }

    pub(super) fn scale(&mut self, row: Row) -> ScaledRow {
        let position = (row.position - self.first) / self.unit;
        let count = position.round();
        let is_count = self.counts && (position - count).abs() < Self::MAX_ROUNDING;
        let position = if is_count { count } else { position };
        let increment = position - self.before;
        self.before = position;
        self.has_moved |= position.abs() > if self.counts { Self::AT_REST } else { 0.0 };
        let reference = row.reference.unwrap_or(row.position);
        ScaledRow {
            row,
            increment,
            error: (reference - row.position) / self.unit,
        }
    }
}
