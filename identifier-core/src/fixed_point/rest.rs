use super::arithmetic::{WORD_BITS, Word, word};
use crate::measurement::travel::Travel;
use crate::units::Units;

/// [`Travel`] on integers: counts with 16 fraction bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedTravel {
    fading: Word,
}

impl FixedTravel {
    const FRACTION: u32 = 16;
    const LEAST: i64 = (Travel::<f64>::LEAST as i64) << Self::FRACTION;
    /// As far as the product below bears: 65 536 counts.
    const MOST: i64 = 1 << 32;

    pub(super) fn new(units: &Units) -> Self {
        Self {
            fading: word(units.sample_time() / Travel::<f64>::MEMORY, 0),
        }
    }

    /// Takes in the counts of a sample; true while the servo stays where it is.
    #[inline]
    pub(super) fn stays(&self, travelled: &mut i64, counts: i32) -> bool {
        // At most 2^32 times 2^30, and 2^31 times 2^16.
        let faded = (*travelled * i64::from(self.fading.to_bits())) >> WORD_BITS;
        let moved = i64::from(counts.unsigned_abs()) << Self::FRACTION;
        *travelled = (*travelled + moved - faded).min(Self::MOST);
        *travelled < Self::LEAST
    }
}
