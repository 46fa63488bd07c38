use crate::constants::{Encode, encode};
use crate::number::Arithmetic;
use crate::unrolled::each;

/// The most terms of the series.
const MAX_TERMS: usize = 6;

/// The exact zero-order-hold step of q̈ = −a q̇ + w for a held acceleration w.
///
/// In machine units, with x = a T, the motion over a time τ (in samples) from velocity v is
///
/// h₂ = (xτ − 1 + e^(−xτ))/(xτ)² and h₁ = (1 − e^(−xτ))/(xτ) = 1 − xτ h₂.
///
/// Δq = v τ + h₂ τ² A and v⁺ = v + h₁ τ A, with A = w − x v.
///
/// This is the closed form of the linear step. Only h₂ needs a series, and a large velocity does not hide a small
/// acceleration. The series ∑ (−xτ)ᵏ/(k + 2)! is cut after [`Arithmetic::SERIES_TERMS`]. Double precision keeps the fifth
/// power: the relative error is below 10⁻⁸ for |xτ| ≤ 0.2, and 10⁻⁶ at the limit 0.5. Single precision keeps the
/// fourth: the error is below its rounding for |xτ| ≤ 0.15, and 2·10⁻⁵ at the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ZeroOrderHoldStep<N> {
    coefficients: [N; MAX_TERMS],
}

encode! {
    [N: Encode] ZeroOrderHoldStep<N> as "ZeroOrderHoldStep" { coefficients }
}

/// A motion over one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<N: Arithmetic> {
    /// The distance moved, Δq.
    pub increment: N,
    /// The velocity at the end.
    pub velocity: N::Fine,
}

impl<N: Arithmetic> Motion<N> {
    /// No motion.
    #[inline]
    pub(crate) fn none() -> Self {
        Self::steady(N::ZERO)
    }

    /// With this velocity throughout.
    #[inline]
    pub(crate) fn steady(velocity: N) -> Self {
        Self {
            increment: velocity,
            velocity: velocity.fine(),
        }
    }
}

/// The response to an acceleration over a time: the distance and the velocity that it adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Response<N> {
    /// Distance per acceleration, h₂ τ².
    pub displacement: N,
    /// Velocity per acceleration, h₁ τ.
    pub velocity: N,
}

impl<N: Arithmetic> Response<N> {
    /// The motion over a whole sample from `velocity` under the held acceleration `drive`.
    #[inline(always)]
    pub(crate) fn motion(&self, x: N::Factor, drive: N, velocity: N::Fine) -> Motion<N> {
        let now = N::of_fine(velocity);
        let acceleration = drive - now.by(x);
        let mut after = velocity;
        N::add_nearly(&mut after, self.velocity, acceleration);
        Motion {
            increment: now + self.displacement(acceleration),
            velocity: after,
        }
    }

    /// The distance that an acceleration adds.
    #[inline(always)]
    pub(crate) fn displacement(&self, acceleration: N) -> N {
        self.displacement.times(acceleration).quartered()
    }
}

impl<N: Arithmetic> ZeroOrderHoldStep<N> {
    /// The largest |a T| that the series is meant for.
    pub(crate) const LARGEST_RATE: f64 = 0.5;

    /// The step; it has no parameter.
    pub(crate) fn new() -> Self {
        let mut factorial = 1.0;
        let mut sign = 1.0;
        let coefficients = core::array::from_fn(|k| {
            factorial *= (k + 2) as f64;
            let coefficient = sign / factorial;
            sign = -sign;
            N::signal(coefficient, 0)
        });
        Self { coefficients }
    }

    /// The response over a whole sample.
    #[inline(always)]
    pub(crate) fn response(&self, x: N::Factor) -> Response<N> {
        let mut displacement = self.coefficients[N::SERIES_TERMS - 1];
        each::<MAX_TERMS>(|i| {
            let power = MAX_TERMS - 1 - i;
            if power + 1 < N::SERIES_TERMS {
                displacement = displacement.by(x) + self.coefficients[power];
            }
        });
        Response {
            displacement,
            velocity: N::ONE - displacement.by(x),
        }
    }

    /// The response over a part τ of a sample.
    #[inline]
    pub(crate) fn partial_response(&self, x: N::Factor, part: N) -> Response<N> {
        let Response {
            displacement,
            velocity,
        } = self.response(N::factor_part(x, part));
        Response {
            displacement: displacement.part(part).part(part),
            velocity: velocity.part(part),
        }
    }

    /// Moves one sample from `velocity` under the held acceleration `drive`, with x = a T.
    #[inline(always)]
    pub(crate) fn process(&self, x: N::Factor, drive: N, velocity: N::Fine) -> Motion<N> {
        self.response(x).motion(x, drive, velocity)
    }
}

impl<N: Arithmetic> Default for ZeroOrderHoldStep<N> {
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
            let motion = ZeroOrderHoldStep::<f64>::new().process(x, drive, velocity);
            let decayed = libm::exp(-x);
            let h1 = -libm::expm1(-x) / x;
            let h2 = (1.0 - h1) / x;
            let scale = drive.abs() + velocity.abs();
            prop_assert!((motion.velocity - (decayed * velocity + h1 * drive)).abs() < 1e-8 * scale);
            prop_assert!((motion.increment - (h1 * velocity + h2 * drive)).abs() < 1e-8 * scale);
        }

        #[test]
        fn two_parts_are_a_whole(
            x in 0.0_f64..0.2,
            drive in -1.0_f64..1.0,
            velocity in -1.0_f64..1.0,
            part in 0.01_f64..0.99,
        ) {
            let step = ZeroOrderHoldStep::<f64>::new();
            let advance = |velocity: f64, part: f64| {
                let response = step.partial_response(x, part);
                let acceleration = drive - x * velocity;
                Motion {
                    increment: velocity * part + response.displacement * acceleration,
                    velocity: velocity + response.velocity * acceleration,
                }
            };
            let first = advance(velocity, part);
            let second = advance(first.velocity, 1.0 - part);
            let whole = step.process(x, drive, velocity);
            prop_assert!((first.increment + second.increment - whole.increment).abs() < 1e-8);
            prop_assert!((second.velocity - whole.velocity).abs() < 1e-8);
        }
    }

    #[test]
    fn error_at_the_largest_rate_is_as_documented() {
        let x = ZeroOrderHoldStep::<f64>::LARGEST_RATE;
        let exact = (x - 1.0 + libm::exp(-x)) / (x * x);
        let motion = ZeroOrderHoldStep::<f64>::new().process(x, 1.0, 0.0);
        assert!((motion.increment / exact - 1.0).abs() < 1e-6);
    }
}
