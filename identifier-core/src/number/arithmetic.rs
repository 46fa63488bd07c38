use core::fmt::Debug;
use core::ops::{Add, Neg, Sub};

use super::{Number, RunningSum, within};
use crate::constants::Encode;

/// The arithmetic of a sample of controller and gradient: that of any [`Number`], and of the word of fixed point.
///
/// In fixed point a signal is a fraction of its full scale, 2^exponent. [`Arithmetic::by`] and [`Arithmetic::part`] keep
/// it, a product by [`Arithmetic::times`] has four times the two full scales, and shifts change it. In floating point
/// every change of scale compiles to nothing. The default is zero.
pub trait Arithmetic:
    Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Send
    + 'static
{
    /// Multiplies a signal: a constant of the configuration, or an estimate.
    type Factor: Copy + Debug + PartialEq + Send;
    /// Takes a signal to another full scale.
    type Shift: Copy + Debug + PartialEq + Send;
    /// A state with more digits than a signal.
    type Fine: Copy + Debug + PartialEq + Send;
    /// A slow sum, which keeps increments far below its value.
    type Sum: Copy + Debug + PartialEq + Send;
    /// The offset that is added to the whole counts of a setpoint: position units, in fixed point counts.
    type Offset: Copy + Debug;
    /// Takes counts to a full scale.
    type Counts: Copy + Debug + PartialEq + Send;
    /// Sum and double sum of a signal over some time.
    type Integral: Copy + Debug + PartialEq + Send;
    /// The number in which the background computes.
    type Real: Number;

    /// Zero.
    const ZERO: Self;
    /// One; in fixed point the largest word.
    const ONE: Self;
    /// The largest error or increment that is taken. In fixed point both saturate.
    const REACH: Self;
    /// Sums of no signal.
    const NOTHING: Self::Integral;
    /// Terms of the series of a zero-order-hold step that the format resolves, at most 6.
    const SERIES_TERMS: usize;
    /// Signals have full scales.
    const IS_FIXED: bool;

    /// A value as a signal of full scale 2^exponent.
    fn signal(value: f64, exponent: i32) -> Self;
    /// A factor from a full scale of 2^from to one of 2^to; in fixed point the result is below one half.
    fn factor(value: f64, from: i32, to: i32) -> Self::Factor;
    /// Up by 0 to 30 bits, for a signal with that room.
    fn raise(bits: i32) -> Self::Shift;
    /// Down by at least two bits.
    fn lower(bits: i32) -> Self::Shift;
    /// Counts to a full scale of 2^exponent.
    fn counts(exponent: i32) -> Self::Counts;
    /// True if a factor moves its result by 2^bits last bits at full scale.
    fn is_felt(factor: Self::Factor, bits: i32) -> bool;
    /// The largest signal that may be shifted left by this number of bits.
    fn most_raised(bits: i32) -> Self;
    /// The signal as a value.
    fn value(self, exponent: i32) -> f64;

    /// Counts as a signal; in fixed point they saturate.
    fn increment(moved: i32, counts: Self::Counts) -> Self;
    /// The distance of a setpoint, whole counts and an offset, from a count. In fixed point it saturates.
    fn distance(setpoint: i32, offset: Self::Offset, count: i32, counts: Self::Counts) -> Self;

    /// Times a factor.
    #[must_use]
    fn by(self, factor: Self::Factor) -> Self;
    /// Times a part of one.
    #[must_use]
    fn part(self, part: Self) -> Self;
    /// The same, rounded towards zero.
    #[inline]
    #[must_use]
    fn decayed(self, part: Self) -> Self {
        self.part(part)
    }
    /// The product, of four times the product of the full scales.
    #[must_use]
    fn times(self, other: Self) -> Self;
    /// This signal over another that is not negative, at most about one.
    #[must_use]
    fn quotient(self, divisor: Self) -> Self;
    /// The same value at twice the full scale.
    #[inline]
    #[must_use]
    fn coarser(self) -> Self {
        self
    }
    /// The same value at a quarter of the full scale.
    #[inline]
    #[must_use]
    fn quartered(self) -> Self {
        self
    }
    /// Shifted up.
    #[inline]
    #[must_use]
    fn raised(self, _: Self::Shift) -> Self {
        self
    }
    /// Shifted down.
    #[inline]
    #[must_use]
    fn lowered(self, _: Self::Shift) -> Self {
        self
    }
    /// In fixed point within its full scale.
    #[inline]
    #[must_use]
    fn saturated(self) -> Self {
        self
    }
    /// In fixed point within ± a magnitude.
    #[inline]
    #[must_use]
    fn saturated_to(self, _: Self) -> Self {
        self
    }
    /// In fixed point within half of its full scale.
    #[inline]
    #[must_use]
    fn saturated_to_half(self) -> Self {
        self
    }
    /// True within the full scale.
    #[inline]
    fn is_within(self) -> bool {
        true
    }
    /// The width of a range for [`Arithmetic::is_surely_between`].
    fn sure_width(low: Self, high: Self) -> Self;
    /// True within a range, and false for NaN. In floating point it is also false within a rounding of `high`, for the
    /// least instructions.
    fn is_surely_between(self, low: Self, high: Self, width: Self) -> bool;
    /// False for NaN and the infinities.
    fn is_finite(self) -> bool;
    /// |x|.
    #[must_use]
    fn magnitude(self) -> Self;
    /// The signal of a full scale of one quarter as a factor.
    fn as_factor(self) -> Self::Factor;
    /// A part of a factor.
    fn factor_part(factor: Self::Factor, part: Self) -> Self::Factor;

    /// A signal as a state.
    fn fine(self) -> Self::Fine;
    /// A state as a signal.
    fn of_fine(fine: Self::Fine) -> Self;
    /// Adds a signal of a finer scale.
    fn add_fine(fine: &mut Self::Fine, x: Self, shift: Self::Shift);
    /// Adds y times a part of one near to one.
    fn add_nearly(fine: &mut Self::Fine, part: Self, y: Self);
    /// state ← pole · state + gain · x, for pole + gain = 1. Returns the state.
    fn low_pass(state: &mut Self::Fine, pole: Self, gain: Self::Factor, x: Self) -> Self;

    /// A signal as a sum.
    fn sum(self) -> Self::Sum;
    /// A sum as a signal.
    fn of_sum(sum: Self::Sum) -> Self;
    /// Adds a signal of a finer scale; in fixed point a sum stops at its full scale.
    fn gather(sum: &mut Self::Sum, x: Self, shift: Self::Shift);
    /// Adds a product as [`Arithmetic::times`] has it, y raised before.
    fn gather_product(sum: &mut Self::Sum, x: Self, y: Self, shift: Self::Shift);
    /// The same where y cannot be raised: the step stops at the sum's full scale.
    fn gather_far(sum: &mut Self::Sum, x: Self, y: Self, shift: Self::Shift);

    /// Adds a signal to its sum, and the sum to the double sum. In fixed point 512 signals have space.
    fn integrate(self, integral: &mut Self::Integral);
    /// Sum and double sum of a signal of a full scale of 2^exponent.
    fn integrals(integral: &Self::Integral, exponent: i32) -> [Self::Real; 2];

    /// The value moved into `[low, high]`.
    #[inline]
    #[must_use]
    fn bounded(self, low: Self, high: Self) -> Self {
        within(self, low, high)
    }

    /// The signal, negative where `forward` is false.
    #[inline]
    #[must_use]
    fn directed(self, forward: bool) -> Self {
        if forward { self } else { -self }
    }
}

/// An arithmetic whose constants can be written as words.
pub(crate) trait Encoded:
    Arithmetic<Factor: Encode, Shift: Encode, Counts: Encode, Real: Encode> + Encode
{
}

impl<N> Encoded for N where
    N: Arithmetic<Factor: Encode, Shift: Encode, Counts: Encode, Real: Encode> + Encode
{
}

impl<N: Number> Arithmetic for N {
    type Factor = N;
    type Shift = ();
    type Fine = N;
    type Sum = N::Sum;
    type Offset = N;
    type Counts = ();
    type Integral = [N; 2];
    type Real = N;

    const NOTHING: [N; 2] = [<N as Number>::ZERO; 2];
    const ZERO: Self = <N as Number>::ZERO;
    const ONE: Self = <N as Number>::ONE;
    const REACH: Self = <N as Number>::REACH;
    const SERIES_TERMS: usize = <N as Number>::SERIES_TERMS;
    const IS_FIXED: bool = false;

    fn signal(value: f64, _: i32) -> Self {
        N::from_f64(value)
    }

    fn factor(value: f64, _: i32, _: i32) -> N {
        N::from_f64(value)
    }

    fn raise(_: i32) {}

    fn lower(_: i32) {}

    fn counts(_: i32) {}

    fn is_felt(_: N, _: i32) -> bool {
        true
    }

    fn most_raised(_: i32) -> N {
        <N as Number>::ZERO
    }

    fn value(self, _: i32) -> f64 {
        self.to_f64()
    }

    #[inline]
    fn increment(moved: i32, (): ()) -> N {
        N::from_count(moved)
    }

    #[inline]
    fn distance(setpoint: i32, offset: N, count: i32, (): ()) -> N {
        N::from_count(setpoint.wrapping_sub(count)) + offset
    }

    #[inline]
    fn by(self, factor: N) -> N {
        self * factor
    }

    #[inline]
    fn part(self, part: N) -> N {
        self * part
    }

    #[inline]
    fn times(self, other: N) -> N {
        self * other
    }

    #[inline]
    fn quotient(self, divisor: N) -> N {
        self * divisor.reciprocal()
    }

    /// Less than the width by more than the rounding of a distance from `low`.
    fn sure_width(low: N, high: N) -> N {
        let width = high.to_f64() - low.to_f64();
        N::from_f64(width * (1.0 - 2.0 * N::EPSILON))
    }

    #[inline(always)]
    fn is_surely_between(self, low: N, _: N, width: N) -> bool {
        (self - low).is_from_zero_to(width)
    }

    #[inline]
    fn is_finite(self) -> bool {
        Number::is_finite(self)
    }

    #[inline]
    fn magnitude(self) -> N {
        Number::magnitude(self)
    }

    #[inline]
    fn as_factor(self) -> N {
        self
    }

    #[inline]
    fn factor_part(factor: N, part: N) -> N {
        factor * part
    }

    #[inline]
    fn fine(self) -> N {
        self
    }

    #[inline]
    fn of_fine(fine: N) -> N {
        fine
    }

    #[inline]
    fn add_fine(fine: &mut N, x: N, (): ()) {
        *fine += x;
    }

    #[inline]
    fn add_nearly(fine: &mut N, part: N, y: N) {
        *fine += part * y;
    }

    #[inline]
    fn low_pass(state: &mut N, pole: N, gain: N, x: N) -> N {
        *state = pole * *state + gain * x;
        *state
    }

    #[inline]
    fn sum(self) -> N::Sum {
        N::Sum::new(self)
    }

    #[inline]
    fn of_sum(sum: N::Sum) -> N {
        sum.value()
    }

    #[inline]
    fn gather(sum: &mut N::Sum, x: N, (): ()) {
        sum.add(x);
    }

    #[inline]
    fn gather_product(sum: &mut N::Sum, x: N, y: N, (): ()) {
        sum.add(x * y);
    }

    fn gather_far(sum: &mut N::Sum, x: N, y: N, (): ()) {
        sum.add(x * y);
    }

    #[inline(always)]
    fn integrate(self, [sum, double]: &mut [N; 2]) {
        *sum += self;
        *double += *sum;
    }

    fn integrals(integral: &[N; 2], _: i32) -> [N; 2] {
        *integral
    }
}
