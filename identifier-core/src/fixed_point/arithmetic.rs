//! Words, accumulators and the products between them.

use fixed::types::{I2F30, I4F60};

/// A quantity as a fraction of its full scale, at most one in magnitude: 32 bits, Q2.30, so one
/// guard bit.
pub type Word = I2F30;

/// A sum of products of words: 64 bits, Q4.60, so that seven products of full scale add up without
/// a carry out of the top.
pub type Accumulator = I4F60;

/// Fraction bits of a [`Word`].
pub(super) const WORD_BITS: i32 = 30;

/// Fraction bits of an [`Accumulator`].
pub(super) const ACCUMULATOR_BITS: i32 = 60;

/// The exponent of the smallest power of two that is above a magnitude; the magnitude must be
/// finite. That of zero is the lowest of all.
pub(super) fn exponent_above(magnitude: f64) -> i32 {
    let (mantissa, exponent) = libm::frexp(libm::fabs(magnitude));
    if mantissa == 0.0 { -60 } else { exponent }
}

/// 2^exponent.
pub(super) fn power(exponent: i32) -> f64 {
    libm::ldexp(1.0, exponent)
}

/// A value as a word of full scale 2^exponent, saturated there.
pub(super) fn word(value: f64, exponent: i32) -> Word {
    // A cast saturates, and makes zero of what is no number.
    limit(Word::from_bits(
        libm::rint(libm::ldexp(value, WORD_BITS - exponent)) as i32,
    ))
}

/// A value as an accumulator of full scale 2^exponent.
pub(super) fn accumulator(value: f64, exponent: i32) -> Accumulator {
    Accumulator::from_bits(libm::rint(libm::ldexp(value, ACCUMULATOR_BITS - exponent)) as i64)
}

/// A word as a value.
pub(super) fn value(word: Word, exponent: i32) -> f64 {
    libm::ldexp(word.to_num::<f64>(), exponent)
}

/// The word within ±1.
#[inline]
pub(super) fn limit(word: Word) -> Word {
    between(word, -Word::ONE, Word::ONE)
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

/// x·y, exactly: its exponent is the sum of theirs.
#[inline]
pub(super) fn product(x: Word, y: Word) -> Accumulator {
    x.wide_mul(y)
}

/// The accumulator shifted up by `left` places, saturated, or down if negative; what falls off the
/// end is below 2⁻⁶⁰ of full scale.
#[inline]
pub(super) fn shifted(x: Accumulator, left: i32) -> Accumulator {
    let bits = x.to_bits();
    Accumulator::from_bits(if left <= 0 {
        // Further than 63 places nothing is left but the sign.
        bits >> left.unsigned_abs().min(63)
    } else {
        far_left(bits, left.unsigned_abs())
    })
}

/// A shift up is the exception: full scales are chosen so that products fit.
#[cold]
fn far_left(bits: i64, left: u32) -> i64 {
    saturating_left(bits, left)
}

/// x·y as a word, to the nearest: never more than one, so nothing is to be saturated.
#[inline]
pub(super) fn word_product(x: Word, y: Word) -> Word {
    const HALF: i64 = 1 << (WORD_BITS - 1);
    let bits = (x.wide_mul(y).to_bits() + HALF) >> WORD_BITS;
    Word::from_bits(bits as i32)
}

/// The accumulator as a word of the same exponent, to the nearest, saturated at ±1.
#[inline]
pub(super) fn narrow(x: Accumulator) -> Word {
    let bits = rounded_right(x.to_bits(), (ACCUMULATOR_BITS - WORD_BITS).unsigned_abs());
    let one = i64::from(Word::ONE.to_bits());
    // Within ±2³⁰ by the clamp.
    Word::from_bits(between(bits, -one, one) as i32)
}

/// The word as an accumulator of the same exponent.
#[inline]
pub(super) fn wide(x: Word) -> Accumulator {
    Accumulator::from_bits(i64::from(x.to_bits()) << (ACCUMULATOR_BITS - WORD_BITS))
}

/// x/2^right to the nearest, halves up.
#[inline]
pub(super) fn rounded_right(x: i64, right: u32) -> i64 {
    match right {
        0 => x,
        1..=62 => {
            let half = 1_i64 << (right - 1);
            x.saturating_add(half) >> right
        }
        _ => 0,
    }
}

/// x·2^left, saturated.
#[inline]
pub(super) fn saturating_left(x: i64, left: u32) -> i64 {
    if left >= 63 {
        return x.signum().saturating_mul(i64::MAX);
    }
    let most = i64::MAX >> left;
    if x > most {
        i64::MAX
    } else if x < -most {
        -i64::MAX
    } else {
        x << left
    }
}

/// A factor of the configuration that takes a word to an accumulator of another exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coefficient {
    word: Word,
    left: i32,
}

impl Coefficient {
    /// `factor` from a quantity of full scale 2^from to one of full scale 2^to.
    pub(super) fn new(factor: f64, from: i32, to: i32) -> Self {
        let own = exponent_above(factor);
        Self {
            word: word(factor, own),
            left: own + from - to,
        }
    }

    /// factor · x.
    #[inline]
    pub(super) fn apply(&self, x: Word) -> Accumulator {
        shifted(product(self.word, x), self.left)
    }

    /// Whether a full-scale input still moves the output by a word's last bit but ten.
    pub(super) fn is_felt(&self) -> bool {
        self.word == Word::ZERO || self.left > -(WORD_BITS - 10)
    }
}

/// n/d for 0 ≤ n and 0 < d, at most one; by multiplications alone.
///
/// Three Newton steps r ← r (2 − d r) on d normalised to [½, 1), from the line 48/17 − 32/17 d whose
/// error of at most 1/17 they square to 4·10⁻³, 10⁻⁵ and 10⁻¹⁰.
#[inline]
pub(super) fn quotient(n: Word, d: Word) -> Word {
    if n >= d {
        return Word::ONE;
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
    let bits = rounded_right(scaled.saturating_mul(r), WORD_BITS.unsigned_abs());
    Word::from_bits(between(bits, 0, i64::from(Word::ONE.to_bits())) as i32)
}

/// 48/17 and 32/17 with 30 fraction bits.
const LINE_START: i64 = (48_i64 << 30) / 17;
const LINE_SLOPE: i64 = (32_i64 << 30) / 17;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_coefficient_multiplies(
            factor in prop_oneof![-1e3_f64..1e3, -1e-3_f64..1e-3],
            x in -1.0_f64..1.0,
            from in -8_i32..20,
        ) {
            let to = exponent_above(factor * power(from)) + 1;
            let coefficient = Coefficient::new(factor, from, to);
            let found = narrow(coefficient.apply(word(x, 0)));
            let exact = factor * x * power(from - to);
            prop_assert!((found.to_num::<f64>() - exact).abs() < 4e-9, "{found} {exact}");
        }

        #[test]
        fn the_quotient_is_that_of_numbers(n in 1e-6_f64..1.0, d in 1e-6_f64..1.0) {
            let found = quotient(word(n, 0), word(d, 0)).to_num::<f64>();
            // The two words are each off by half of their last bit.
            let tolerance = 4e-9 + 1e-9 / d;
            prop_assert!((found - (n / d).min(1.0)).abs() < tolerance, "{n}/{d}: {found}");
        }

        #[test]
        fn nothing_wraps(x in any::<i64>(), left in -70_i32..70) {
            let shifted = shifted(Accumulator::from_bits(x), left);
            prop_assert!(shifted.to_bits() == 0 || (shifted.to_bits() > 0) == (x > 0));
            prop_assert!(left <= 0 || shifted.to_bits().unsigned_abs() >= x.unsigned_abs().min(i64::MAX.unsigned_abs()));
            let narrowed = narrow(Accumulator::from_bits(x));
            prop_assert!(narrowed.abs() <= Word::ONE);
        }
    }

    #[test]
    fn the_largest_and_the_smallest_are_what_they_are() {
        assert_eq!(exponent_above(1.0), 1);
        assert_eq!(exponent_above(0.75), 0);
        assert_eq!(exponent_above(-5.0), 3);
        assert_eq!(quotient(Word::ONE, Word::ONE), Word::ONE);
        assert_eq!(quotient(Word::ZERO, Word::ONE), Word::ZERO);
    }
}
