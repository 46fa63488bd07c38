//! The part of a log that is kept in memory to be scanned, whatever the length of the log.

use super::Row;

/// Samples without a break, SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Segment {
    /// Measured positions.
    pub(crate) positions: Vec<f64>,
    /// Commands; empty where the log has none.
    pub(crate) commands: Vec<f64>,
    /// References; empty where the log has none.
    pub(crate) references: Vec<f64>,
    /// Number of its first sample in the log.
    first: u64,
    /// True if the motion before it is unknown.
    begins: bool,
}

impl Segment {
    fn at(first: u64, begins: bool) -> Self {
        Self {
            first,
            begins,
            ..Self::default()
        }
    }

    fn push(&mut self, row: &Row) {
        self.positions.push(row.position);
        self.commands.extend(row.command);
        self.references.extend(row.reference);
    }

    /// Distance between its lowest and its highest position.
    fn range(&self) -> f64 {
        let (low, high) = extremes(&self.positions);
        high - low
    }

    /// True if another one follows without a break.
    fn is_followed_by(&self, next: &Self) -> bool {
        !next.begins && self.first + self.positions.len() as u64 == next.first
    }
}

/// Lowest and highest of some numbers.
pub(crate) fn extremes(numbers: &[f64]) -> (f64, f64) {
    let beyond_all = (f64::INFINITY, f64::NEG_INFINITY);
    (numbers.iter()).fold(beyond_all, |(low, high), x| (low.min(*x), high.max(*x)))
}

/// Gathers the blocks of a log in which the servo moves furthest: all of a short log.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Excerpt {
    kept: Vec<Segment>,
    current: Segment,
    samples: u64,
}

impl Excerpt {
    /// Samples of a block.
    const BLOCK: usize = 16_384;
    /// Blocks that are kept.
    const MAX_BLOCKS: usize = 8;

    pub(super) fn add(&mut self, row: &Row) {
        if row.begins || self.current.positions.len() == Self::BLOCK {
            let next = Segment::at(self.samples, row.begins);
            let full = std::mem::replace(&mut self.current, next);
            self.keep(full);
        }
        self.current.push(row);
        self.samples += 1;
    }

    fn keep(&mut self, block: Segment) {
        if block.positions.is_empty() {
            return;
        }
        self.kept.push(block);
        if self.kept.len() > Self::MAX_BLOCKS {
            let ranges = self.kept.iter().map(Segment::range).enumerate();
            let least = ranges.min_by(|(_, one), (_, other)| one.total_cmp(other));
            if let Some((least, _)) = least {
                self.kept.remove(least);
            }
        }
    }

    /// The segments, in the order of the log.
    pub(super) fn finish(mut self) -> Vec<Segment> {
        let last = std::mem::take(&mut self.current);
        self.keep(last);
        let mut segments: Vec<Segment> = Vec::new();
        for block in self.kept {
            match segments.last_mut() {
                Some(before) if before.is_followed_by(&block) => {
                    before.positions.extend(block.positions);
                    before.commands.extend(block.commands);
                    before.references.extend(block.references);
                }
                _ => segments.push(block),
            }
        }
        segments
    }
}

#[cfg(test)]
mod tests {
    use super::{Excerpt, Row};

    fn excerpt(rows: impl Iterator<Item = (f64, bool)>) -> Vec<super::Segment> {
        let mut excerpt = Excerpt::default();
        for (line, (position, begins)) in rows.enumerate() {
            let mut row = Row::at(line as u64, 0.0);
            (row.position, row.begins) = (position, begins);
            excerpt.add(&row);
        }
        excerpt.finish()
    }

    #[test]
    fn a_short_log_is_kept_whole_and_divided_only_at_its_breaks() {
        let segments = excerpt((0..40_000).map(|k| (f64::from(k), k == 0 || k == 30_000)));
        let lengths: Vec<_> = segments.iter().map(|s| s.positions.len()).collect();
        assert_eq!(lengths, [30_000, 10_000]);
        assert!(
            segments[0]
                .positions
                .iter()
                .zip(0..)
                .all(|(x, k)| (*x - f64::from(k)).abs() < 0.5)
        );
    }

    #[test]
    fn of_a_long_log_the_blocks_of_the_largest_motion_are_kept() {
        let moving = 600_000..700_000;
        let segments = excerpt((0..1_000_000).map(|k| {
            let position = if moving.contains(&k) {
                f64::from(k)
            } else {
                0.0
            };
            (position, k == 0)
        }));
        let kept: usize = segments.iter().map(|s| s.positions.len()).sum();
        assert!(kept <= 8 * 16_384, "{kept}");
        let found = segments.iter().flat_map(|s| &s.positions);
        assert_eq!(found.filter(|x| **x != 0.0).count(), 100_000);
    }
}
