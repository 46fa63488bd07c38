use crate::constants::{Encode, encode};
use crate::number::Arithmetic;
use crate::unrolled::each;

/// Keeps the estimates inside a parameter range.
///
/// An estimate beyond a bound is moved back to it. As Γ is diagonal, this is the shortest distance in the norm of the
/// storage function (12), ½ θ̃ᵀ Γ⁻¹ θ̃. The projection never raises that function, so the stability proof holds
/// (Ioannou and Sun, Robust Adaptive Control, 1996, section 4.4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Projection<N, const P: usize> {
    low: [N; P],
    high: [N; P],
    /// See [`Arithmetic::is_surely_between`].
    width: [N; P],
}

encode! {
    [N: Encode, const P: usize] Projection<N, P> as "Projection" { low, high, width }
}

impl<N: Arithmetic, const P: usize> Projection<N, P> {
    /// The parameter range from `low` to `high`, machine units.
    pub(crate) fn new(low: [N; P], high: [N; P]) -> Self {
        Self {
            low,
            high,
            width: core::array::from_fn(|i| N::sure_width(low[i], high[i])),
        }
    }

    /// Which estimates are at a bound.
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

    /// Moves the estimates back into the parameter range if they have left it. A step that overflows leaves no
    /// estimate: it begins again at its lower bound.
    pub(crate) fn apply(&self, estimates: &mut [N::Sum; P]) {
        for ((estimate, low), high) in estimates.iter_mut().zip(self.low).zip(self.high) {
            let outside = N::of_sum(*estimate);
            let is_inside = |value: N| value >= low && value <= high;
            if !is_inside(outside) {
                let bound = outside.bounded(low, high);
                *estimate = if is_inside(bound) { bound } else { low }.sum();
            }
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
            gamma in prop::array::uniform2(0.1_f64..10.0),
        ) {
            let projection = Projection::<f64, 2>::new([0.0; 2], [1.0; 2]);
            let mut estimates = outside;
            projection.apply(&mut estimates);
            prop_assert!(estimates.iter().all(|x| (0.0..=1.0).contains(x)), "{estimates:?}");
            if projection.surely_contains(&outside) {
                prop_assert_eq!(estimates.map(f64::to_bits), outside.map(f64::to_bits));
            }
            let sure = outside.map(|x| x.clamp(0.0, 1.0 - 1e-15));
            prop_assert!(projection.surely_contains(&sure), "{sure:?}");

            let storage = |x: [f64; 2]| -> f64 {
                (0..2).map(|i| (x[i] - truth[i]).powi(2) / gamma[i]).sum()
            };
            prop_assert!(storage(estimates) <= storage(outside) + 1e-9);
        }
    }
}
