//! Words, accumulators, sums and the products between them.
//!
//! Each form is one instruction of a Cortex-M4. One is a product of two words of 32 bits, rounded to its high half. The
//! other adds such a product to 64 bits.

use crate::constants::{Decoder, Encode, encode, fingerprint};
use fixed::types::{I2F30, I4F60};

/// A quantity as a fraction of its full scale, from −1 to just below 1. It has 32 bits, Q2.30, so one guard bit.
pub type Word = I2F30;

impl Encode for Word {
    const SHAPE: u32 = fingerprint("Word", &[]);
    const WORDS: usize = 1;

    fn encode(&self, word: &mut dyn FnMut(u32)) {
        self.to_bits().encode(word);
    }

    #[inline(always)]
    fn decode(words: &mut Decoder<'_>) -> Self {
        Self::from_bits(i32::decode(words))
    }
}

/// A sum of products of words: 64 bits, Q4.60. Seven products of full scale add up without a carry out of the top.
pub(super) type Accumulator = I4F60;

/// The largest word, one less a last bit. Sum and difference of any two words from −1 to here fit 32 bits. A limit to
/// this range is one `SSAT`.
pub(super) const FULL: Word = Word::from_bits((1 << WORD_BITS) - 1);

/// Fraction bits of a [`Word`].
pub(super) const WORD_BITS: i32 = 30;

/// Fraction bits of an [`Accumulator`].
pub(super) const ACCUMULATOR_BITS: i32 = 60;

/// The exponent of the smallest power of two that is above a magnitude; the magnitude must be
/// finite. That of zero and of subnormal numbers is the lowest of all.
pub(super) fn exponent_above(magnitude: f64) -> i32 {
    /// Fraction bits of a double, and the exponent of the numbers from one to two.
    const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;
    const BIAS: i32 = f64::MAX_EXP - 1;
    // Not `frexp`, which calls itself: a chip's stack would have no bound.
    match (magnitude.to_bits() >> FRACTION & 0x7ff) as i32 {
        0 => -60,
        biased => biased - BIAS + 1,
    }
}

/// 2^exponent.
pub(super) fn power(exponent: i32) -> f64 {
    libm::ldexp(1.0, exponent)
}

/// A value as a word of full scale 2^exponent, saturated there.
pub(super) fn word(value: f64, exponent: i32) -> Word {
    // A cast saturates, and makes zero of NaN.
    limit(Word::from_bits(
        libm::rint(libm::ldexp(value, WORD_BITS - exponent)) as i32,
    ))
}

/// A word as a value.
pub(super) fn value(word: Word, exponent: i32) -> f64 {
    libm::ldexp(word.to_num::<f64>(), exponent)
}

/// One half, the largest part that one of two may have of a full scale.
const HALF: Word = Word::from_bits(1 << (WORD_BITS - 1));

/// The word within −1 and [`FULL`].
#[inline]
pub(super) fn limit(word: Word) -> Word {
    between(word, -Word::ONE, FULL)
}

/// The word within one half.
#[inline]
pub(super) fn limit_to_half(word: Word) -> Word {
    between(word, -HALF, HALF - Word::DELTA)
}

/// True if the word is within −1 and [`FULL`], so that its guard bit is free.
#[inline]
pub(super) fn is_within(word: Word) -> bool {
    word.to_bits().wrapping_add(1 << WORD_BITS) >= 0
}

/// x within [low, high], for low ≤ high: a `clamp` without the panic that checks this.
#[inline]
pub(super) fn between<T: PartialOrd>(x: T, low: T, high: T) -> T {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

/// x·y/2³², to the nearest.
#[inline]
fn high(x: i32, y: i32) -> i32 {
    const HALF: i64 = 1 << 31;
    ((i64::from(x) * i64::from(y) + HALF) >> 32) as i32
}

/// x·y, exactly.
#[inline]
fn wide_product(x: Word, y: Word) -> i64 {
    i64::from(x.to_bits()) * i64::from(y.to_bits())
}

/// x·y as a word, to the nearest.
#[inline]
pub(super) fn product(x: Word, y: Word) -> Word {
    const HALF: i64 = 1 << (WORD_BITS - 1);
    Word::from_bits(((wide_product(x, y) + HALF) >> WORD_BITS) as i32)
}

/// x·y as a word, towards zero.
#[inline]
pub(super) fn product_towards_zero(x: Word, y: Word) -> Word {
    Word::from_bits((wide_product(x, y) / (1 << WORD_BITS)) as i32)
}

/// sum + x·y.
#[inline]
pub(super) fn with_product(sum: Accumulator, x: Word, y: Word) -> Accumulator {
    Accumulator::from_bits(sum.to_bits() + wide_product(x, y))
}

/// x·y as a quarter: a word of four times the full scale of their product.
#[inline]
pub(super) fn quarter_product(x: Word, y: Word) -> Word {
    Word::from_bits(high(x.to_bits(), y.to_bits()))
}

/// The accumulator as a word of the same exponent, downwards.
#[inline]
pub(super) fn narrow(x: Accumulator) -> Word {
    Word::from_bits((x.to_bits() >> (ACCUMULATOR_BITS - WORD_BITS)) as i32)
}

/// The word as an accumulator of the same exponent.
#[inline]
pub(super) fn wide(x: Word) -> Accumulator {
    Accumulator::from_bits(i64::from(x.to_bits()) << (ACCUMULATOR_BITS - WORD_BITS))
}

/// A fraction of one with 32 fraction bits, below one half in magnitude. It multiplies a word in one instruction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fraction(i32);

encode! {
    [] Fraction as "Fraction" { 0 }
}

impl Fraction {
    pub(super) const ZERO: Self = Self(0);

    fn from_value(value: f64) -> Self {
        // A cast saturates.
        Self(libm::rint(libm::ldexp(value, 32)) as i32)
    }

    /// The fraction of a word.
    #[inline]
    pub(super) fn times(self, x: Word) -> Word {
        Word::from_bits(high(self.0, x.to_bits()))
    }

    /// The fraction of a part of one.
    #[inline]
    pub(super) fn part(self, part: Word) -> Self {
        Self(product(Word::from_bits(self.0), part).to_bits())
    }
}

/// A power of two that shifts a word up. This is one `MUL`; a shift would need a check that it is below 32.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Raise(i32);

encode! {
    [] Raise as "Raise" { 0 }
}

impl Raise {
    /// By 0 to 30 places.
    pub(super) fn by(places: i32) -> Self {
        Self(1 << places.clamp(0, 30))
    }

    /// The word shifted up; it must not overflow.
    #[inline]
    pub(super) fn apply(self, x: Word) -> Word {
        Word::from_bits(x.to_bits() * self.0)
    }

    /// A whole number shifted up to a word; it must not overflow.
    #[inline]
    pub(super) fn whole(self, x: i32) -> Word {
        Word::from_bits(x * self.0)
    }

    /// The largest word that does not overflow.
    pub(super) fn most(self) -> Word {
        Word::from_bits(FULL.to_bits() / self.0)
    }
}

/// A slow sum: 64 bits, Q2.62, whose high half is a word, so that reading it costs nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Sum(i64);

encode! {
    [] Sum as "Sum" { 0 }
}

/// Fraction bits of a [`Sum`].
pub(super) const SUM_BITS: i32 = 62;

impl Sum {
    pub(super) const ZERO: Self = Self(0);

    /// A value as a sum of full scale 2^exponent, saturated at twice that.
    pub(super) fn from_value(value: f64, exponent: i32) -> Self {
        Self(libm::rint(libm::ldexp(value, SUM_BITS - exponent)) as i64)
    }

    /// Last bits of a sum of full scale 2^exponent.
    pub(super) fn bits_of_one(exponent: i32) -> f32 {
        libm::ldexpf(1.0, SUM_BITS - exponent)
    }

    /// A sum from a number of last bits, within its full scale.
    pub(super) fn from_bits(bits: f32) -> Self {
        const MAX_BITS: i64 = (1 << SUM_BITS) - 1;
        // A cast saturates, and makes zero of NaN.
        Self(between(bits as i64, -MAX_BITS, MAX_BITS))
    }

    /// The sum as a value.
    pub(super) fn value(self, exponent: i32) -> f64 {
        libm::ldexp(self.0 as f64, exponent - SUM_BITS)
    }

    /// The sum as a word of the same exponent, downwards.
    #[inline]
    pub(super) fn word(self) -> Word {
        Word::from_bits((self.0 >> 32) as i32)
    }

    /// The sum of full scale one quarter as a fraction.
    #[inline]
    pub(super) fn fraction(self) -> Fraction {
        Fraction((self.0 >> 32) as i32)
    }

    /// Adds last bits of a finer scale.
    #[inline]
    pub(super) fn add(&mut self, x: Word, weight: Weight) {
        self.0 += i64::from(x.to_bits()) * i64::from(weight.0);
    }

    /// Adds a product of two words, at most a half, in the sum's own last bits: see
    /// [`Sum::exponent_of_factor`].
    #[inline]
    pub(super) fn add_product(&mut self, x: Word, y: Word) {
        self.0 += wide_product(x, y);
    }

    /// The same of a product times 2^`up`; one that would leave the sum's range is one.
    pub(super) fn add_product_raised(&mut self, x: Word, y: Word, up: Raise) {
        const MAX_BITS: i64 = (1 << SUM_BITS) - 1;
        let product = wide_product(x, y);
        self.0 += between(product.saturating_mul(i64::from(up.0)), -MAX_BITS, MAX_BITS);
    }

    /// The exponent of a factor whose product has the last bits of a sum of full scale 2^to. The other factor has the
    /// exponent `other`.
    pub(super) fn exponent_of_factor(to: i32, other: i32) -> i32 {
        to - other + ACCUMULATOR_BITS - SUM_BITS
    }
}

/// Last bits of a [`Sum`] per last bit of a word of a finer scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weight(i32);

encode! {
    [] Weight as "Weight" { 0 }
}

impl Weight {
    /// Least and largest difference of the exponents.
    pub(super) const APART: (i32, i32) = (2, 32);

    /// From words of full scale 2^from to sums of full scale 2^to.
    pub(super) fn new(from: i32, to: i32) -> Self {
        let (least, most) = Self::APART;
        Self(1 << (32 - (to - from).clamp(least, most)))
    }
}

/// A factor of the configuration that converts a word to another full scale. The result is at most half of that scale.
/// It is off by less than an eighth of the output's last bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coefficient(Fraction);

encode! {
    [] Coefficient as "Coefficient" { 0 }
}

impl Coefficient {
    /// The least exponent of an output for which a factor stays below half of it.
    pub(super) fn least(factor: f64, from: i32) -> i32 {
        exponent_above(factor) + from + 1
    }

    /// `factor` from a quantity of full scale 2^from to one of full scale 2^to, `to` being no less
    /// than [`Coefficient::least`].
    pub(super) fn new(factor: f64, from: i32, to: i32) -> Self {
        Self(Fraction::from_value(libm::ldexp(factor, from - to)))
    }

    /// factor · x, to the nearest.
    #[inline]
    pub(super) fn apply(self, x: Word) -> Word {
        self.0.times(x)
    }

    /// True if a full-scale input moves the output by at least 2^`bits` last bits.
    pub(super) fn is_felt(self, bits: i32) -> bool {
        self.0.0.abs() >> (bits + 32 - WORD_BITS) > 0
    }
}

/// n/d for 0 ≤ n and 0 < d ≤ 1, at most one; by multiplications alone.
///
/// Three Newton steps r ← r (2 − d r) on d normalised to [½, 1). They begin at the line 48/17 − 32/17 d, whose error is
/// at most 1/17. They square it to 4·10⁻³, 10⁻⁵ and 10⁻¹⁰.
#[cold]
#[inline(never)]
pub(super) fn quotient(n: Word, d: Word) -> Word {
    if n >= d {
        return FULL;
    }
    let bits = d.to_bits().unsigned_abs();
    let up = bits.leading_zeros().saturating_sub(2);
    // Both in Q2.30: d in [½, 1), r in (1, 2].
    let d = i64::from(bits) << up;
    let mut r = LINE_START - ((LINE_SLOPE * d) >> WORD_BITS);
    for _ in 0..3 {
        let miss = (2_i64 << WORD_BITS) - ((d * r) >> WORD_BITS);
        r = (r * miss) >> WORD_BITS;
    }
    let scaled = i64::from(n.to_bits()) << up;
    let bits = scaled.saturating_mul(r) >> WORD_BITS;
    Word::from_bits(between(bits, 0, i64::from(FULL.to_bits())) as i32)
}

/// 48/17 and 32/17 with 30 fraction bits.
const LINE_START: i64 = (48_i64 << 30) / 17;
const LINE_SLOPE: i64 = (32_i64 << 30) / 17;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_above_is_the_smallest() {
        for (magnitude, exponent) in [
            (1.0, 1),
            (-1.0, 1),
            (0.999, 0),
            (2.0, 2),
            (3.9, 2),
            (1e300, 997),
            (f64::MIN_POSITIVE, -1021),
            (0.0, -60),
        ] {
            assert_eq!(exponent_above(magnitude), exponent, "{magnitude}");
        }
    }

    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_coefficient_multiplies(
            factor in prop_oneof![-1e3_f64..1e3, -1e-3_f64..1e-3],
            x in -1.0_f64..1.0,
            from in -8_i32..20,
            room in 0_i32..8,
        ) {
            let to = Coefficient::least(factor, from) + room;
            let found = Coefficient::new(factor, from, to).apply(word(x, 0));
            let exact = factor * x * power(from - to);
            prop_assert!(exact.abs() <= 0.5);
            prop_assert!((found.to_num::<f64>() - exact).abs() < 1e-9, "{found} {exact}");
        }

        #[test]
        fn products_are_those_of_numbers(x in -1.0_f64..1.0, y in -1.0_f64..1.0) {
            let (p, q) = (word(x, 0), word(y, 0));
            prop_assert!((product(p, q).to_num::<f64>() - x * y).abs() < 2e-9);
            prop_assert!((quarter_product(p, q).to_num::<f64>() - x * y / 4.0).abs() < 2e-9);
            let half = Fraction::from_value(0.499 * x);
            prop_assert!((half.times(q).to_num::<f64>() - 0.499 * x * y).abs() < 2e-9);
            prop_assert!((half.part(q).times(FULL).to_num::<f64>() - 0.499 * x * y).abs() < 3e-9);
        }

        #[test]
        fn a_sum_adds_what_a_finer_scale_gives_it(
            terms in prop::collection::vec(-1.0_f64..1.0, 1..50),
            apart in 6_i32..20,
        ) {
            let mut sum = Sum::ZERO;
            let mut exact = 0.0;
            for term in terms {
                sum.add(word(term, 0), Weight::new(3, 3 + apart));
                exact += word(term, 0).to_num::<f64>() * 8.0;
            }
            prop_assert!((sum.value(3 + apart) - exact).abs() < 1e-9);
            let word = value(sum.word(), 3 + apart);
            prop_assert!((word - exact).abs() < power(apart - 26));
        }

        #[test]
        fn a_sum_takes_products_raised_or_not(
            x in -0.5_f64..0.5,
            y in -1.0_f64..1.0,
            up in 0_i32..29,
        ) {
            let mut sum = Sum::from_value(0.3, 0);
            sum.add_product_raised(word(x, 0), word(y, 0), Raise::by(up));
            let step = (x * y * power(up - 2)).clamp(-1.0, 1.0);
            let tolerance = 1e-15 + 2e-9 * power(up);
            prop_assert!((sum.value(0) - (0.3 + step)).abs() < tolerance);
            let mut raised = sum;
            raised.add_product_raised(word(x, 0), word(y, 0), Raise::by(0));
            sum.add_product(word(x, 0), word(y, 0));
            prop_assert_eq!(raised, sum);
        }

        #[test]
        fn the_quotient_is_that_of_numbers(n in 1e-6_f64..1.0, d in 1e-6_f64..1.0) {
            let found = quotient(word(n, 0), word(d, 0)).to_num::<f64>();
            // The two words are each off by half of their last bit.
            let tolerance = 4e-9 + 1e-9 / d;
            prop_assert!((found - (n / d).min(1.0)).abs() < tolerance, "{n}/{d}: {found}");
        }

        #[test]
        fn no_step_leaves_a_sum(start in -1.0_f64..=1.0, x: i32, y: i32, up in 0_i32..29) {
            // Words with all of their guard bits used.
            let mut sum = Sum::from_value(start, 0);
            sum.add_product_raised(Word::from_bits(x), Word::from_bits(y), Raise::by(up));
            prop_assert!(sum.value(0).abs() <= 2.0);
        }

        #[test]
        fn a_word_is_within_what_it_is_limited_to(bits: i32) {
            let word = Word::from_bits(bits);
            prop_assert_eq!(is_within(word), limit(word) == word);
            prop_assert!(is_within(limit(word)));
            prop_assert!(limit_to_half(word).abs() <= HALF);
        }
    }

    #[test]
    fn the_largest_and_the_smallest_are_what_they_are() {
        assert_eq!(exponent_above(1.0), 1);
        assert_eq!(exponent_above(0.75), 0);
        assert_eq!(exponent_above(-5.0), 3);
        assert_eq!(quotient(FULL, FULL), FULL);
        assert_eq!(quotient(Word::ZERO, FULL), Word::ZERO);
        assert_eq!(word(2.0, 0), FULL);
        assert_eq!(word(f64::NAN, 0), Word::ZERO);
    }
}
