//! A movable origin, so that many turns cost no resolution.

use crate::number::Number;

/// The count from which positions are measured.
///
/// The loop depends on differences of positions only, so its origin may move at any sample. As
/// counts are integers and a move is a whole number of counts, moving is exact: nothing is
/// rounded, however many turns the servo has made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Origin {
    count: i64,
}

impl Origin {
    /// An origin at a count.
    #[must_use]
    pub fn new(count: i64) -> Self {
        Self { count }
    }

    /// The count at the origin.
    #[must_use]
    pub fn count(&self) -> i64 {
        self.count
    }

    /// The position of a count relative to the origin, in counts.
    ///
    /// Exact within [`Number::LARGEST_EXACT_COUNT`] of the origin; beyond the range of 32 bits it
    /// is the nearest end of that range, which the loop then refuses as too far apart.
    #[inline]
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        reason = "limited to the range of the target first"
    )]
    pub fn position<N: Number>(&self, count: i64) -> N {
        let relative = count
            .saturating_sub(self.count)
            .clamp(i64::from(i32::MIN), i64::from(i32::MAX));
        N::from_count(relative as i32)
    }

    /// Moves the origin to `count` if that lies so far away that fractions of a count (of the
    /// reference) would be rounded to coarser than 2⁻⁸, and returns by how much it moved.
    ///
    /// The caller takes the same amount from whatever else is measured from this origin:
    /// [`ControlState::shift_origin`](crate::control::ControlState::shift_origin).
    pub fn follow<N: Number>(&mut self, count: i64) -> Option<N> {
        /// Steps per count that the reference keeps.
        const FRACTION: i64 = 1 << 8;
        let reach = N::LARGEST_EXACT_COUNT / FRACTION;
        let away = count.saturating_sub(self.count);
        if away.saturating_abs() <= reach {
            return None;
        }
        let moved = self.position(count);
        self.count = count;
        Some(moved)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exactness is the property under test")]
mod tests {
    use super::Origin;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn positions_stay_exact_over_any_journey(
            start in -1_i64 << 50..1 << 50,
            moves in prop::collection::vec(-60_000_i64..60_000, 1..300),
        ) {
            let mut origin = Origin::new(start);
            let mut count = start;
            let mut position = 0.0_f32;
            for step in moves {
                count += step;
                if let Some(moved) = origin.follow::<f32>(count) {
                    position -= moved;
                }
                position += step as f32;
                prop_assert_eq!(origin.position::<f32>(count), position);
            }
        }

        #[test]
        fn no_count_overflows(origin: i64, count: i64) {
            let position: f64 = Origin::new(origin).position(count);
            prop_assert!(position.abs() <= 2_147_483_648.0);
        }
    }
}
