use super::arithmetic::{Coefficient, Word, limit, product_towards_zero, word};
use super::ranges::FullScales;
use crate::constants::encode;
use crate::control::reference_filter_pole;
use crate::error::OutOfRange;
use crate::units::Units;

/// The filter of the reference on words, as [`ReferenceFilter`](crate::control::ReferenceFilter) on numbers.
///
/// The remaining lag, E times the lag before, is rounded towards zero. So the filtered reference reaches a constant
/// reference exactly, in whole last bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedReferenceFilter {
    /// E.
    pole: Word,
    /// From an increment's full scale to the error's.
    to_error: Coefficient,
}

encode! {
    [] FixedReferenceFilter as "FixedReferenceFilter" { pole, to_error }
}

impl FixedReferenceFilter {
    /// # Errors
    /// `reference_filter` out of its range, as for numbers.
    pub(super) fn new(
        units: &Units,
        time_constant: f64,
        scales: &FullScales,
    ) -> Result<Self, OutOfRange> {
        Ok(Self {
            pole: word(reference_filter_pole(units, time_constant)?, 0),
            to_error: Coefficient::new(1.0, scales.velocity, scales.position),
        })
    }

    /// Converts the error of a sample, within −1 and 1, to the error of the filtered reference. `increment` is that
    /// since the last sample, `filtered` the last filtered error.
    #[inline]
    pub(super) fn process(&self, filtered: &mut Word, error: Word, increment: Word) -> Word {
        // An increment is at most a quarter of an error.
        let unmoved = limit(*filtered - self.to_error.apply(increment));
        *filtered = error - product_towards_zero(self.pole, error - unmoved);
        *filtered
    }
}
