//! The numbers a loop may be computed in, and the sums that must not lose small increments.

mod arithmetic;
mod complex;
mod running_sum;

pub use arithmetic::Arithmetic;
pub(crate) use arithmetic::Encoded;
pub use complex::Complex;
pub(crate) use running_sum::Compensated;
pub use running_sum::RunningSum;

use crate::unrolled::each;
use core::fmt::Debug;
use core::ops::{Add, AddAssign, Mul, Neg, Sub};

/// The arithmetic of the hot path.
///
/// All code of a sample uses this trait only. It has ring operations, comparison, and a sum that keeps small
/// increments. Configuration is computed in `f64` and enters through [`Number::from_f64`] when a part is built, never
/// in the loop. The default is zero.
pub trait Number:
    Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + Send
    + 'static
{
    /// A sum that runs for months without losing increments far below its value.
    type Sum: RunningSum<Self>;

    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// The largest magnitude up to which every encoder count is represented exactly.
    const LARGEST_EXACT_COUNT: i64;
    /// The same bound as a number. It is the largest error or increment that a loop accepts, and the largest output
    /// error of its model.
    const REACH: Self;
    /// Terms of the series of a zero-order-hold step of the model that the format resolves, at most 6.
    const SERIES_TERMS: usize;
    /// Spacing of the numbers next above one.
    const EPSILON: f64;

    /// The nearest number to a configuration value: finite, unless the value and the format are not.
    fn from_f64(value: f64) -> Self;

    /// The value for a report.
    fn to_f64(self) -> f64;

    /// A number of encoder counts; exact up to [`Number::LARGEST_EXACT_COUNT`].
    fn from_count(count: i32) -> Self;

    /// False for NaN and the infinities; always true in formats that have neither.
    fn is_finite(self) -> bool;

    /// 1/x for positive, normal x, by multiplications alone, to a few units in the last place.
    ///
    /// The hot path has no division; this serves the rare sample in which a guard must scale.
    fn reciprocal(self) -> Self;

    /// 1/√x for positive, normal x, by multiplications alone in `f32`, to a few units in the last place.
    fn reciprocal_root(self) -> Self;

    /// The whole part, towards zero; for values within ±2³¹.
    fn whole(self) -> i32;

    /// sin x and cos x, without a platform's libm, so that every machine computes the same bits. In `f32` the error is
    /// up to 1.2·10⁻³ within 200 revolutions. Beyond them it is larger, as the angle itself is rounded.
    fn sine_cosine(self) -> (Self, Self);

    /// The value moved into `[low, high]`.
    #[inline]
    #[must_use]
    fn limited(self, low: Self, high: Self) -> Self {
        within(self, low, high)
    }

    /// The larger of two; the other where one is not a number.
    #[inline]
    #[must_use]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    /// The smaller of two; the other where one is not a number.
    #[inline]
    #[must_use]
    fn smaller(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    /// |x|.
    #[must_use]
    fn magnitude(self) -> Self;

    /// True from +0 to a number that is not negative; false for NaN.
    fn is_from_zero_to(self, most: Self) -> bool;
}

/// A value moved into `[low, high]`.
#[inline]
fn within<T: PartialOrd>(value: T, low: T, high: T) -> T {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

impl Number for f32 {
    type Sum = Compensated<Self>;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const LARGEST_EXACT_COUNT: i64 = 1 << Self::MANTISSA_DIGITS;
    const REACH: Self = (1_u32 << Self::MANTISSA_DIGITS) as Self;
    const SERIES_TERMS: usize = 5;
    const EPSILON: f64 = Self::EPSILON as f64;

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
    fn from_f64(value: f64) -> Self {
        /// The least that would be rounded to an infinity. By its bits: a comparison of numbers takes constants in memory.
        const BEYOND: u64 = (f32::MAX as f64 + (1_u128 << 103) as f64).to_bits();
        const SIGN: u64 = 1 << 63;
        if value.to_bits() & !SIGN < BEYOND {
            return value as Self;
        }
        // What is not a number becomes one, too.
        Self::from_bits(Self::MAX.to_bits() | ((value.to_bits() & SIGN) >> 32) as u32)
    }

    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline]
    #[expect(
        clippy::cast_precision_loss,
        reason = "exact in the documented range, rounded beyond it"
    )]
    fn from_count(count: i32) -> Self {
        count as Self
    }

    #[inline]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    #[inline]
    fn magnitude(self) -> Self {
        self.abs()
    }

    /// Numbers that are not negative have the order of their bits; those of all others are above.
    #[inline(always)]
    fn is_from_zero_to(self, most: Self) -> bool {
        self.to_bits() <= most.to_bits()
    }

    /// Three Newton steps r ← r (2 − x r) from the exponent-negating integer guess. They square its error of at most 12
    /// % to 1.5 %, 2·10⁻⁴ and below 10⁻⁷.
    #[inline]
    fn reciprocal(self) -> Self {
        /// Negates the exponent and halves the worst error of the mantissa's straight line
        /// (minimax over one octave).
        const GUESS: u32 = 0x7ef3_11c7;
        let mut r = Self::from_bits(GUESS.wrapping_sub(self.to_bits()));
        each::<3>(|_| r = r * (2.0 - self * r));
        r
    }

    /// Three Newton steps r ← r (3 − x r²)/2 from the guess that halves and negates the exponent. They reduce its error
    /// of at most 3.5 % to 0.2 %, 5·10⁻⁶ and rounding. A root by software takes five times as long.
    #[inline]
    fn reciprocal_root(self) -> Self {
        /// (C. Lomont, "Fast inverse square root", 2003)
        const GUESS: u32 = 0x5f37_5a86;
        let half = 0.5 * self;
        let mut r = Self::from_bits(GUESS.wrapping_sub(self.to_bits() >> 1));
        each::<3>(|_| r = r * (1.5 - half * r * r));
        r
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "in the documented range")]
    fn whole(self) -> i32 {
        self as i32
    }

    #[inline]
    fn sine_cosine(self) -> (Self, Self) {
        (micromath::F32Ext::sin(self), micromath::F32Ext::cos(self))
    }
}

impl Number for f64 {
    type Sum = Self;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const LARGEST_EXACT_COUNT: i64 = 1 << Self::MANTISSA_DIGITS;
    const REACH: Self = (1_u64 << Self::MANTISSA_DIGITS) as Self;
    const SERIES_TERMS: usize = 6;
    const EPSILON: f64 = Self::EPSILON;

    #[inline]
    fn from_f64(value: f64) -> Self {
        value
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline]
    fn from_count(count: i32) -> Self {
        Self::from(count)
    }

    #[inline]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    #[inline]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn is_from_zero_to(self, most: Self) -> bool {
        self.to_bits() <= most.to_bits()
    }

    #[inline]
    fn reciprocal(self) -> Self {
        1.0 / self
    }

    #[inline]
    fn reciprocal_root(self) -> Self {
        1.0 / libm::sqrt(self)
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "in the documented range")]
    fn whole(self) -> i32 {
        self as i32
    }

    #[inline]
    fn sine_cosine(self) -> (Self, Self) {
        libm::sincos(self)
    }
}

#[cfg(test)]
mod tests {
    use super::Number;
    use proptest::prelude::*;

    /// Angles as models use them: an order of ripple times an angle of up to a revolution.
    #[test]
    fn f32_sine_and_cosine_are_off_by_what_is_stated() {
        const HIGHEST_ORDER: u32 = 200;
        const ANGLES: u32 = 1_000_000;
        let mut largest = [0.0_f64; 2];
        for k in 0..=ANGLES {
            let order = f64::from(1 + k % HIGHEST_ORDER);
            let revolutions = 2.0 * f64::from(k) / f64::from(ANGLES) - 1.0;
            let angle = (core::f64::consts::TAU * order * revolutions) as f32;
            let (sine, cosine) = angle.sine_cosine();
            let exact = libm::sincos(f64::from(angle));
            let off = [f64::from(sine) - exact.0, f64::from(cosine) - exact.1];
            for (largest, off) in largest.iter_mut().zip(off) {
                *largest = largest.max(off.abs());
            }
        }
        for largest in largest {
            assert!((1.1e-3..1.2e-3).contains(&largest), "off by {largest:e}");
        }
    }

    #[test]
    fn f32_is_always_a_number() {
        let most = f64::from(f32::MAX);
        // Half of the last digit beyond it is rounded down, and no further.
        for beyond in [
            1.000_000_02 * most,
            1.000_000_1 * most,
            1.8e40,
            f64::INFINITY,
        ] {
            let both = [beyond, -beyond].map(<f32 as Number>::from_f64);
            let most = [f32::MAX, f32::MIN].map(f32::to_bits);
            assert_eq!(both.map(f32::to_bits), most, "{beyond:e}");
        }
        assert!(<f32 as Number>::from_f64(f64::NAN).is_finite());
        assert_eq!(<f32 as Number>::from_f64(0.1).to_bits(), 0.1_f32.to_bits());
    }

    proptest! {
        #[test]
        fn f32_reciprocals_are_within_a_few_units_in_the_last_place(x in 1e-30_f32..1e30) {
            let root = libm::sqrt(f64::from(x));
            for (found, of) in [(Number::reciprocal(x), f64::from(x)), (Number::reciprocal_root(x), root)] {
                let relative = (f64::from(found) * of - 1.0).abs();
                prop_assert!(relative < 4.0 * f64::from(f32::EPSILON), "1/{of}: off by {relative:e}");
            }
        }

        #[test]
        fn limited_stays_inside(x in -1e6_f64..1e6, low in -10.0..0.0, width in 0.0..10.0) {
            let y = x.limited(low, low + width);
            prop_assert!((low..=low + width).contains(&y));
        }
    }
}
