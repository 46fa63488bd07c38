use fixed::types::{I0F32, I2F30, I2F62, I16F16};

use crate::constants::{Decoder, Encode, encode, fingerprint};
use crate::number::Arithmetic;

/// A quantity as a fraction of its full scale, from −1 to just below 1. It has 32 bits, Q2.30, so one guard bit.
pub type Word = I2F30;

/// Fraction bits of a [`Word`].
const BITS: i32 = 30;

/// The largest word, one less a last bit. Sum and difference of any two words from −1 to here fit 32 bits. A limit to
/// this range is one `SSAT`.
const FULL: Word = Word::from_bits((1 << BITS) - 1);

/// The least word, −1.
const LEAST: Word = Word::from_bits(-(1 << BITS));

/// One half, the largest part that one of two may have of a full scale.
const HALF: Word = Word::from_bits(1 << (BITS - 1));

/// The largest sum: one, less a last bit.
const FULL_SUM: i64 = (1 << 62) - 1;

/// A number of fixed point as the integer that it is.
macro_rules! encode_bits {
    ($($fixed:ty as $name:literal;)*) => {$(
        impl Encode for $fixed {
            const SHAPE: u32 = fingerprint($name, &[]);
            const WORDS: usize = 1;

            fn encode(&self, word: &mut dyn FnMut(u32)) {
                self.to_bits().encode(word);
            }

            #[inline(always)]
            fn decode(words: &mut Decoder<'_>) -> Self {
                Self::from_bits(i32::decode(words))
            }
        }
    )*};
}

encode_bits! {
    Word as "Word";
    I0F32 as "Factor";
}

/// Counts to a full scale of a power of two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountScale {
    /// Counts of the full scale.
    full: i32,
    up: i32,
}

encode! {
    [] CountScale as "CountScale" { full, up }
}

/// Sum and double sum of words without their last bits, exactly. A piece of counts has none of these bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WordIntegral {
    sum: i32,
    double: i64,
}

/// Bits of a word that a sum of 512 words has no space for.
const INTEGRAL_BITS: i32 = 8;

/// The nearest of a range about zero, beyond it.
#[cold]
fn saturated(moved: i32, most: i32) -> i32 {
    most * moved.signum()
}

/// x·y, exactly.
#[inline]
fn wide(x: i32, y: i32) -> i64 {
    i64::from(x) * i64::from(y)
}

/// x·y/2³², to the nearest: one instruction of a Cortex-M4.
#[inline]
fn high(x: i32, y: i32) -> i32 {
    const HALF: i64 = 1 << 31;
    ((wide(x, y) + HALF) >> 32) as i32
}

/// x·y/2³⁰, to the nearest.
#[inline]
fn product(x: i32, y: i32) -> i32 {
    const HALF: i64 = 1 << (BITS - 1);
    ((wide(x, y) + HALF) >> BITS) as i32
}

#[inline]
fn with(sum: I2F62, x: i32, y: i32) -> I2F62 {
    I2F62::from_bits(sum.to_bits() + wide(x, y))
}

/// A shift is a power of two that is multiplied: a shift would need a check that it is below 32.
impl Arithmetic for Word {
    type Factor = I0F32;
    type Shift = i32;
    type Fine = I2F62;
    type Sum = I2F62;
    type Offset = I16F16;
    type Counts = CountScale;
    type Integral = WordIntegral;
    type Real = f32;

    const NOTHING: WordIntegral = WordIntegral { sum: 0, double: 0 };
    const ZERO: Self = Self::ZERO;
    const ONE: Self = FULL;
    const REACH: Self = Self::MAX;
    const SERIES_TERMS: usize = 6;
    const IS_FIXED: bool = true;

    fn signal(value: f64, exponent: i32) -> Self {
        // A cast saturates, and makes zero of NaN.
        Self::from_bits(libm::rint(libm::ldexp(value, BITS - exponent)) as i32).saturated()
    }

    fn factor(value: f64, from: i32, to: i32) -> I0F32 {
        I0F32::from_bits(libm::rint(libm::ldexp(value, 32 + from - to)) as i32)
    }

    fn raise(bits: i32) -> i32 {
        1 << bits.clamp(0, BITS)
    }

    fn lower(bits: i32) -> i32 {
        1 << (32 - bits.clamp(2, 32))
    }

    fn counts(exponent: i32) -> CountScale {
        let exponent = exponent.clamp(0, BITS);
        CountScale {
            full: 1 << exponent,
            up: 1 << (BITS - exponent),
        }
    }

    fn is_felt(factor: I0F32, bits: i32) -> bool {
        factor.to_bits().unsigned_abs() >> (bits + 32 - BITS) > 0
    }

    fn most_raised(bits: i32) -> Self {
        Self::from_bits(FULL.to_bits() >> bits.clamp(0, BITS))
    }

    fn value(self, exponent: i32) -> f64 {
        libm::ldexp(self.to_num::<f64>(), exponent)
    }

    #[inline]
    fn increment(moved: i32, counts: CountScale) -> Self {
        let most = counts.full - 1;
        // One comparison for both sides.
        let is_within = (moved.wrapping_add(most)).cast_unsigned() <= 2 * most.cast_unsigned();
        let moved = if is_within {
            moved
        } else {
            saturated(moved, most)
        };
        Self::from_bits(moved * counts.up)
    }

    /// Counts may wrap at 32 bits: setpoint and position are never further apart than half of that.
    #[inline]
    fn distance(setpoint: i32, offset: I16F16, count: i32, counts: CountScale) -> Self {
        const FRACTION: u32 = I16F16::FRAC_NBITS;
        let offset = offset.to_bits();
        let whole = setpoint
            .wrapping_sub(count)
            .saturating_add(offset >> FRACTION);
        let is_within =
            whole.wrapping_add(counts.full).cast_unsigned() < 2 * counts.full.cast_unsigned();
        // The part of a count, in 2⁻³².
        let (whole, part) = if is_within {
            (whole, offset.cast_unsigned() << (32 - FRACTION))
        } else if whole > 0 {
            (counts.full - 1, u32::MAX)
        } else {
            (-counts.full, 0)
        };
        let part = (u64::from(part) * u64::from(counts.up.cast_unsigned())) >> 32;
        Self::from_bits(whole * counts.up + part as i32)
    }

    #[inline]
    fn by(self, factor: I0F32) -> Self {
        Self::from_bits(high(self.to_bits(), factor.to_bits()))
    }

    #[inline]
    fn part(self, part: Self) -> Self {
        Self::from_bits(product(self.to_bits(), part.to_bits()))
    }

    #[inline]
    fn decayed(self, part: Self) -> Self {
        Self::from_bits((wide(self.to_bits(), part.to_bits()) / (1 << BITS)) as i32)
    }

    #[inline]
    fn times(self, other: Self) -> Self {
        Self::from_bits(high(self.to_bits(), other.to_bits()))
    }

    /// By multiplications alone. Three Newton steps r ← r (2 − d r) on d normalised to [½, 1). They begin at the line
    /// 48/17 − 32/17 d, whose error is at most 1/17. They square it to 4·10⁻³, 10⁻⁵ and 10⁻¹⁰.
    #[cold]
    #[inline(never)]
    fn quotient(self, divisor: Self) -> Self {
        const START: i64 = (48_i64 << BITS) / 17;
        const SLOPE: i64 = (32_i64 << BITS) / 17;
        if self >= divisor {
            return FULL;
        }
        let bits = i64::from(divisor.to_bits().max(1));
        // At least one: a word has a guard bit and a sign.
        let up = (bits as u32).leading_zeros();
        let d = (bits << up) >> 2;
        let mut r = START - ((SLOPE * d) >> BITS);
        for _ in 0..3 {
            let miss = (2_i64 << BITS) - ((d * r) >> BITS);
            r = (r * miss) >> BITS;
        }
        let scaled = (i64::from(self.to_bits()) << up) >> 2;
        let found = (scaled * r) >> BITS;
        Self::from_bits(found.clamp(0, i64::from(FULL.to_bits())) as i32)
    }

    #[inline]
    fn coarser(self) -> Self {
        self >> 1
    }

    #[inline]
    fn quartered(self) -> Self {
        Self::from_bits(self.to_bits() * 4)
    }

    #[inline]
    fn raised(self, shift: i32) -> Self {
        Self::from_bits(self.to_bits() * shift)
    }

    #[inline]
    fn lowered(self, shift: i32) -> Self {
        Self::from_bits(high(self.to_bits(), shift))
    }

    #[inline]
    fn saturated(self) -> Self {
        self.bounded(LEAST, FULL)
    }

    #[inline]
    fn saturated_to(self, most: Self) -> Self {
        self.bounded(-most, most)
    }

    #[inline]
    fn saturated_to_half(self) -> Self {
        self.bounded(-HALF, HALF - Self::DELTA)
    }

    #[inline]
    fn is_within(self) -> bool {
        self.to_bits().wrapping_add(1 << BITS) >= 0
    }

    fn sure_width(_: Self, _: Self) -> Self {
        Self::ZERO
    }

    #[inline(always)]
    fn is_surely_between(self, low: Self, high: Self, _: Self) -> bool {
        self >= low && self <= high
    }

    #[inline]
    fn is_finite(self) -> bool {
        true
    }

    #[inline]
    fn magnitude(self) -> Self {
        self.wrapping_abs()
    }

    #[inline]
    fn as_factor(self) -> I0F32 {
        I0F32::from_bits(self.to_bits())
    }

    #[inline]
    fn factor_part(factor: I0F32, part: Self) -> I0F32 {
        I0F32::from_bits(product(factor.to_bits(), part.to_bits()))
    }

    #[inline]
    fn fine(self) -> I2F62 {
        I2F62::from_bits(i64::from(self.to_bits()) << 32)
    }

    /// The high half, downwards: reading it costs nothing.
    #[inline]
    fn of_fine(fine: I2F62) -> Self {
        Self::from_bits((fine.to_bits() >> 32) as i32)
    }

    #[inline]
    fn add_fine(fine: &mut I2F62, x: Self, shift: i32) {
        *fine = with(*fine, x.to_bits(), shift);
    }

    /// Adds part · y as y + (part − 1) y: only the small second term is a product.
    #[inline]
    fn add_nearly(fine: &mut I2F62, part: Self, y: Self) {
        let lack = (part - I2F30::ONE).to_bits();
        // In halves: as one sum it would become a multiplication of 64 bits.
        let upper = Self::of_fine(*fine).wrapping_add(y).fine();
        let moved = upper.to_bits() | (fine.to_bits() & i64::from(u32::MAX));
        *fine = with(I2F62::from_bits(moved), 4 * lack, y.to_bits());
    }

    /// The state keeps 62 fraction bits, so nothing below a word's last bit is lost in it.
    #[inline]
    fn low_pass(state: &mut I2F62, _: Self, gain: I0F32, x: Self) -> Self {
        let miss = x - Self::of_fine(*state);
        *state = with(*state, miss.to_bits(), gain.to_bits());
        Self::of_fine(*state)
    }

    #[inline]
    fn sum(self) -> I2F62 {
        self.fine()
    }

    #[inline]
    fn of_sum(sum: I2F62) -> Self {
        Self::of_fine(sum)
    }

    #[inline]
    fn gather(sum: &mut I2F62, x: Self, shift: i32) {
        let next = with(*sum, x.to_bits(), shift);
        if Self::of_fine(next).is_within() {
            *sum = next;
        }
    }

    #[inline]
    fn gather_product(sum: &mut I2F62, x: Self, y: Self, shift: i32) {
        // Within its range, which a compiler knows to be 32 bits: otherwise it multiplies 64.
        *sum = with(*sum, x.saturated().to_bits(), y.raised(shift).to_bits());
    }

    fn gather_far(sum: &mut I2F62, x: Self, y: Self, shift: i32) {
        let step = wide(x.to_bits(), y.to_bits()).saturating_mul(i64::from(shift));
        *sum = I2F62::from_bits(sum.to_bits() + step.clamp(-FULL_SUM, FULL_SUM));
    }

    #[inline(always)]
    fn integrate(self, integral: &mut WordIntegral) {
        integral.sum = integral.sum.wrapping_add(self.to_bits() >> INTEGRAL_BITS);
        integral.double = integral.double.wrapping_add(integral.sum.into());
    }

    #[expect(
        clippy::cast_precision_loss,
        reason = "as many digits as the background has"
    )]
    fn integrals(integral: &WordIntegral, exponent: i32) -> [f32; 2] {
        let unit = libm::ldexpf(1.0, exponent - BITS + INTEGRAL_BITS);
        [integral.sum as f32 * unit, integral.double as f32 * unit]
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A value of full scale one.
    fn word(value: f64) -> Word {
        Word::signal(value, 0)
    }

    fn of(sum: I2F62) -> f64 {
        sum.to_num()
    }

    proptest! {
        /// At the ends too, where one count more has no word.
        #[test]
        fn counts_become_the_nearest_word(
            count: i32,
            apart in prop_oneof![any::<i32>(), -3..3_i32],
            ends in -1..=1_i32,
            offset in prop_oneof![any::<i32>(), -70_000..70_000_i32],
            exponent in 0..=30,
        ) {
            let counts = Word::counts(exponent);
            let full = 1_i128 << exponent;
            let apart = apart.wrapping_add(ends.wrapping_shl(exponent as u32));
            let at = |parts: i128| ((parts << (30 - exponent)) >> 16).clamp(-(1 << 30), (1 << 30) - 1);
            let exact = (i128::from(apart) << 16) + i128::from(offset);
            let offset = I16F16::from_bits(offset);
            let distance = Word::distance(count.wrapping_add(apart), offset, count, counts);
            prop_assert_eq!(i128::from(distance.to_bits()), at(exact));
            let moved = i128::from(apart).clamp(1 - full, full - 1);
            let increment = Word::increment(apart, counts);
            prop_assert_eq!(i128::from(increment.to_bits()), at(moved << 16));
        }

        #[test]
        fn a_factor_multiplies(
            factor in prop_oneof![-1e3_f64..1e3, -1e-3_f64..1e-3],
            x in -1.0_f64..1.0,
            from in -8_i32..20,
            room in 0_i32..8,
        ) {
            let to = crate::scales::least(factor, from) + room;
            let found = word(x).by(Word::factor(factor, from, to));
            let exact = factor * x * libm::ldexp(1.0, from - to);
            prop_assert!(exact.abs() <= 0.5);
            prop_assert!((found.to_num::<f64>() - exact).abs() < 1e-9, "{found} {exact}");
        }

        #[test]
        fn products_are_those_of_numbers(x in -1.0_f64..1.0, y in -1.0_f64..1.0) {
            let (p, q) = (word(x), word(y));
            prop_assert!((p.part(q).to_num::<f64>() - x * y).abs() < 2e-9);
            prop_assert!((p.times(q).to_num::<f64>() - x * y / 4.0).abs() < 2e-9);
            let half = Word::factor(0.499 * x, 0, 0);
            prop_assert!((q.by(half).to_num::<f64>() - 0.499 * x * y).abs() < 2e-9);
            let part = Word::factor_part(half, q);
            prop_assert!((FULL.by(part).to_num::<f64>() - 0.499 * x * y).abs() < 3e-9);
        }

        #[test]
        fn a_sum_adds_what_a_finer_scale_gives_it(
            terms in prop::collection::vec(-1.0_f64..1.0, 1..50),
            apart in 6_i32..20,
        ) {
            let (mut sum, mut gathered) = (Word::ZERO.fine(), Word::ZERO.sum());
            let mut exact = 0.0;
            for term in terms {
                Word::add_fine(&mut sum, word(term), Word::lower(apart));
                Word::gather(&mut gathered, word(term), Word::lower(apart));
                exact += word(term).to_num::<f64>() * libm::ldexp(1.0, -apart);
            }
            prop_assert!((of(sum) - exact).abs() < 1e-15);
            prop_assert_eq!(sum, gathered);
            prop_assert!((Word::of_fine(sum).to_num::<f64>() - exact).abs() < 1e-9);
        }

        #[test]
        fn a_sum_takes_products_raised_or_not(
            x in -0.5_f64..0.5,
            y in -1.0_f64..1.0,
            up in 0_i32..29,
        ) {
            let mut sum = word(0.3).sum();
            Word::gather_far(&mut sum, word(x), word(y), Word::raise(up));
            let step = (x * y * libm::ldexp(1.0, up - 2)).clamp(-1.0, 1.0);
            let tolerance = 1e-9 + 2e-9 * libm::ldexp(1.0, up);
            prop_assert!((of(sum) - (0.3 + step)).abs() < tolerance);
            let (mut far, mut near) = (sum, sum);
            let small = word(y * libm::ldexp(1.0, -up)).saturated_to(Word::most_raised(up));
            Word::gather_far(&mut far, word(x), small, Word::raise(up));
            Word::gather_product(&mut near, word(x), small, Word::raise(up));
            prop_assert_eq!(far, near);
        }

        #[test]
        fn the_quotient_is_that_of_numbers(n in 1e-6_f64..1.0, d in 1e-6_f64..1.9) {
            // Beyond one by shifting down.
            let divisor = Word::from_num(d);
            let found = word(n).quotient(divisor).to_num::<f64>();
            // The two words are each off by half of their last bit.
            let tolerance = 4e-9 + 1e-9 / d;
            prop_assert!((found - (n / d).min(1.0)).abs() < tolerance, "{n}/{d}: {found}");
        }

        #[test]
        fn no_step_leaves_a_sum(start in -1.0_f64..=1.0, x: i32, y: i32, up in 0_i32..29) {
            // Words with all of their guard bits used.
            let mut sum = word(start).sum();
            Word::gather_far(&mut sum, Word::from_bits(x), Word::from_bits(y), Word::raise(up));
            prop_assert!(of(sum).abs() <= 2.0);
        }

        #[test]
        fn a_word_is_within_what_it_is_limited_to(bits: i32) {
            let word = Word::from_bits(bits);
            prop_assert_eq!(Arithmetic::is_within(word), word.saturated() == word);
            prop_assert!(Arithmetic::is_within(word.saturated()));
            prop_assert!(word.saturated_to_half().magnitude() <= HALF);
        }
    }

    #[test]
    fn the_largest_and_the_smallest_are_what_they_are() {
        assert_eq!(FULL.quotient(FULL), FULL);
        assert_eq!(Word::ZERO.quotient(FULL), Word::ZERO);
        assert_eq!(Word::ZERO.quotient(Word::ZERO), FULL);
        assert_eq!(word(2.0), FULL);
        assert_eq!(word(f64::NAN), Word::ZERO);
    }
}
