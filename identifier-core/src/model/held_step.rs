use crate::number::Number;

/// The exact zero-order-hold step of q̈ = −a q̇ + w for a held acceleration w.
///
/// In machine units, with x = a T, the motion over one sample from velocity v is
///
/// h₂ = (x − 1 + e⁻ˣ)/x², h₁ = (1 − e⁻ˣ)/x = 1 − x h₂, and with A = w − x v:
/// Δq = v + h₂ A, v⁺ = v + h₁ A.
///
/// It is the closed form of DESIGN's E, g₁, g₂ written so that only h₂ needs a series and
/// a small acceleration is not lost in a large velocity. The series ∑ (−x)ᵏ/(k + 2)! is cut after
/// x⁵: its relative error is below 10⁻⁸ for |x| ≤ 0.2 and 10⁻⁶ at the limit |x| = 0.5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldStep<N> {
    coefficients: [N; 6],
}

/// A motion over one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<N> {
    /// The way gone, Δq.
    pub increment: N,
    /// The velocity at the end.
    pub velocity: N,
}

impl<N: Number> HeldStep<N> {
    /// The largest |a T| that the series is meant for.
    pub const LARGEST_RATE: f64 = 0.5;

    /// The step; it has no parameter.
    #[must_use]
    pub fn new() -> Self {
        let mut factorial = 1.0;
        let mut sign = 1.0;
        let coefficients = core::array::from_fn(|k| {
            factorial *= (k + 2) as f64;
            let coefficient = sign / factorial;
            sign = -sign;
            N::from_f64(coefficient)
        });
        Self { coefficients }
    }

    /// Moves one sample from `velocity` under the held acceleration `drive`, with x = a T.
    #[inline]
    pub fn process(&self, x: N, drive: N, velocity: N) -> Motion<N> {
        let [head @ .., last] = self.coefficients;
        let h2 = head.iter().rev().fold(last, |sum, &c| sum * x + c);
        let h1 = N::ONE - x * h2;
        let acceleration = drive - x * velocity;
        Motion {
            increment: velocity + h2 * acceleration,
            velocity: velocity + h1 * acceleration,
        }
    }
}

impl<N: Number> Default for HeldStep<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_closed_form(
            x in prop_oneof![1e-3_f64..0.2, -0.2..-1e-3],
            drive in -10.0_f64..10.0,
            velocity in -10.0_f64..10.0,
        ) {
            let motion = HeldStep::<f64>::new().process(x, drive, velocity);
            let decayed = (-x).exp();
            let h1 = -(-x).exp_m1() / x;
            let h2 = (1.0 - h1) / x;
            let scale = drive.abs() + velocity.abs();
            prop_assert!((motion.velocity - (decayed * velocity + h1 * drive)).abs() < 1e-8 * scale);
            prop_assert!((motion.increment - (h1 * velocity + h2 * drive)).abs() < 1e-8 * scale);
        }

        #[test]
        fn two_half_steps_are_one_step(x in 0.0_f64..0.2, drive in -1.0_f64..1.0, velocity in -1.0_f64..1.0) {
            let step = HeldStep::<f64>::new();
            // Half the sample time halves x and v, and quarters the acceleration.
            let first = step.process(x / 2.0, drive / 4.0, velocity / 2.0);
            let second = step.process(x / 2.0, drive / 4.0, first.velocity);
            let whole = step.process(x, drive, velocity);
            prop_assert!((first.increment + second.increment - whole.increment).abs() < 1e-8);
            prop_assert!((2.0 * second.velocity - whole.velocity).abs() < 1e-8);
        }
    }

    #[test]
    fn error_at_the_largest_rate_is_as_documented() {
        let x = HeldStep::<f64>::LARGEST_RATE;
        let exact = (x - 1.0 + (-x).exp()) / (x * x);
        let motion = HeldStep::<f64>::new().process(x, 1.0, 0.0);
        assert!((motion.increment / exact - 1.0).abs() < 1e-6);
    }
}
