use crate::constants::{Encode, encode};
use crate::linalg::PositiveDefinite;
use crate::number::Arithmetic;
use crate::unrolled::each;

/// Keeps the estimates inside a parameter range.
///
/// An estimate beyond one bound is moved back to it along the column of Γ. This is the shortest distance in the norm of
/// the storage function (12), ½ θ̃ᵀ Γ⁻¹ θ̃. The projection never raises that function, so the stability proof holds
/// (Ioannou and Sun, Robust Adaptive Control, 1996, section 4.4). Where this would move another estimate beyond its
/// bound, that one is clamped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Projection<N, const P: usize> {
    low: [N; P],
    high: [N; P],
    /// See [`Arithmetic::is_surely_between`].
    width: [N; P],
    direction: [[N; P]; P],
}

encode! {
    [N: Encode, const P: usize] Projection<N, P> as "Projection" { low, high, width, direction }
}

impl<N: Arithmetic, const P: usize> Projection<N, P> {
    /// The parameter range from `low` to `high` for the metric of Γ (machine units).
    #[must_use]
    pub(crate) fn new(low: [N; P], high: [N; P], gamma: &PositiveDefinite<P>) -> Self {
        let entries = gamma.entries();
        Self {
            low,
            high,
            width: core::array::from_fn(|i| N::sure_width(low[i], high[i])),
            direction: core::array::from_fn(|i| {
                core::array::from_fn(|j| N::signal(entries[i][j] / entries[i][i], 0))
            }),
        }
    }

    /// Which estimates are at a bound.
    #[must_use]
    pub(crate) fn at_bounds(&self, estimates: &[N; P]) -> [bool; P] {
        core::array::from_fn(|i| estimates[i] <= self.low[i] || estimates[i] >= self.high[i])
    }

    /// True if all estimates are inside, and but for fixed point not within a rounding of their upper bounds.
    #[inline(always)]
    pub(crate) fn surely_contains(&self, estimates: &[N::Sum; P]) -> bool {
        let mut inside = true;
        each::<P>(|i| {
            let value = N::of_sum(estimates[i]);
            inside &= value.is_surely_between(self.low[i], self.high[i], self.width[i]);
        });
        inside
    }

    /// Moves the estimates back into the parameter range if they have left it.
    pub(crate) fn apply(&self, estimates: &mut [N::Sum; P]) {
        for i in 0..P {
            if !self.is_inside(i, N::of_sum(estimates[i])) {
                self.enter(estimates, i);
            }
        }
    }

    /// False for NaN, too.
    #[inline(always)]
    fn is_inside(&self, place: usize, value: N) -> bool {
        value >= self.low[place] && value <= self.high[place]
    }

    fn enter(&self, estimates: &mut [N::Sum; P], face: usize) {
        let outside = N::of_sum(estimates[face]);
        let bound = outside.bounded(self.low[face], self.high[face]);
        if N::IS_FIXED {
            // Γ is diagonal.
            estimates[face] = bound.sum();
            return;
        }
        let back = bound - outside;
        for j in 0..P {
            let moved = N::of_sum(estimates[j]) + back.part(self.direction[face][j]);
            let moved = moved.bounded(self.low[j], self.high[j]);
            // A step that overflows leaves no estimate.
            let is_number = self.is_inside(j, moved);
            estimates[j] = if is_number { moved } else { self.low[j] }.sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn never_raises_the_storage_function_and_always_ends_inside(
            truth in prop::array::uniform2(0.0_f64..1.0),
            outside in prop::array::uniform2(-3.0_f64..4.0),
            diagonal in prop::array::uniform2(0.1_f64..10.0),
            correlation in -0.9_f64..0.9,
        ) {
            let cross = correlation * libm::sqrt(diagonal[0] * diagonal[1]);
            let gamma = [[diagonal[0], cross], [cross, diagonal[1]]];
            let gamma = PositiveDefinite::new(gamma).expect("positive definite");
            let projection = Projection::<f64, 2>::new([0.0; 2], [1.0; 2], &gamma);
            let mut estimates = outside;
            projection.apply(&mut estimates);
            prop_assert!(estimates.iter().all(|x| (0.0..=1.0).contains(x)), "{estimates:?}");
            if projection.surely_contains(&outside) {
                prop_assert_eq!(estimates.map(f64::to_bits), outside.map(f64::to_bits));
            }
            let sure = outside.map(|x| x.clamp(0.0, 1.0 - 1e-15));
            prop_assert!(projection.surely_contains(&sure), "{sure:?}");

            // One bound at a time; a second one is clamped, for which the argument of the storage
            // function does not hold.
            let faces = outside.iter().filter(|x| !(0.0..=1.0).contains(*x)).count();
            let left_bounds = (0..2).any(|i| {
                let j = 1 - i;
                let back = outside[j].clamp(0.0, 1.0) - outside[j];
                let moved = outside[i] + back * gamma.entries()[i][j] / gamma.entries()[j][j];
                !(0.0..=1.0).contains(&moved) && (0.0..=1.0).contains(&outside[i])
            });
            if faces == 1 && !left_bounds {
                let determinant = diagonal[0] * diagonal[1] - cross * cross;
                let storage = |x: [f64; 2]| {
                    let [p, q] = [x[0] - truth[0], x[1] - truth[1]];
                    (diagonal[1] * p * p - 2.0 * cross * p * q + diagonal[0] * q * q) / determinant
                };
                prop_assert!(storage(estimates) <= storage(outside) + 1e-9);
            }
        }
    }
}
