use super::Number;

/// A sum of many small increments.
pub trait RunningSum<N>: Copy + PartialEq + core::fmt::Debug + Send {
    /// Starts at a value.
    fn new(value: N) -> Self;

    /// The sum, rounded to the number format.
    fn value(self) -> N;

    /// Adds an increment.
    fn add(&mut self, increment: N);
}

impl RunningSum<Self> for f64 {
    #[inline]
    fn new(value: Self) -> Self {
        value
    }

    #[inline]
    fn value(self) -> Self {
        self
    }

    #[inline]
    fn add(&mut self, increment: Self) {
        *self += increment;
    }
}

/// A compensated sum: the rounding error of each addition is carried into the next.
///
/// Kahan, "Further remarks on reducing truncation errors", Communications of the ACM 8(1), 1965. In
/// `f32` an increment below 3·10⁻⁸ of the sum would otherwise vanish. Estimates and integrals of a
/// fast loop move by less than that at every sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensated<N> {
    sum: N,
    excess: N,
}

impl<N: Number> RunningSum<N> for Compensated<N> {
    #[inline]
    fn new(value: N) -> Self {
        Self {
            sum: value,
            excess: N::ZERO,
        }
    }

    #[inline]
    fn value(self) -> N {
        self.sum
    }

    #[inline]
    fn add(&mut self, increment: N) {
        let due = increment - self.excess;
        let sum = self.sum + due;
        self.excess = (sum - self.sum) - due;
        self.sum = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::{Compensated, RunningSum};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn compensated_sum_follows_f64(
            start in -1e4_f32..1e4,
            increments in prop::collection::vec(-1.0_f32..1.0, 1..2000),
        ) {
            let mut sum = Compensated::new(start);
            let mut exact = f64::from(start);
            for &increment in &increments {
                sum.add(increment);
                exact += f64::from(increment);
            }
            let bound = 2.0 * f64::from(f32::EPSILON) * 2e4;
            prop_assert!((f64::from(sum.value()) - exact).abs() <= bound);
        }
    }
}
