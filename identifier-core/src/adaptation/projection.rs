use super::PositiveDefinite;
use crate::number::{Number, RunningSum};

/// Keeps the estimates inside a box.
///
/// An estimate that leaves through one face is moved back onto it along the column of Γ, which is
/// the shortest way in the norm of the storage function (12), ½ θ̃ᵀ Γ⁻¹ θ̃: the projection never
/// raises it, so the stability proof stands (Ioannou and Sun, Robust Adaptive Control, 1996,
/// section 4.4). A corner, where this could leave through the other face, is closed by a plain
/// limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection<N, const P: usize> {
    low: [N; P],
    high: [N; P],
    direction: [[N; P]; P],
}

impl<N: Number, const P: usize> Projection<N, P> {
    /// The box from `low` to `high` (machine units) for the metric of Γ (machine units).
    #[must_use]
    pub fn new(low: [f64; P], high: [f64; P], gamma: &PositiveDefinite<P>) -> Self {
        let entries = gamma.entries();
        Self {
            low: low.map(N::from_f64),
            high: high.map(N::from_f64),
            direction: core::array::from_fn(|i| {
                core::array::from_fn(|j| N::from_f64(entries[i][j] / entries[i][i]))
            }),
        }
    }

    /// Moves the estimates back into the box if they have left it.
    #[inline]
    pub fn apply(&self, estimates: &mut [N::Sum; P]) {
        for i in 0..P {
            let value = estimates[i].value();
            if value < self.low[i] || value > self.high[i] {
                self.enter(estimates, i);
            }
        }
    }

    #[cold]
    fn enter(&self, estimates: &mut [N::Sum; P], face: usize) {
        let outside = estimates[face].value();
        let back = outside.limited(self.low[face], self.high[face]) - outside;
        for j in 0..P {
            let moved = estimates[j].value() + back * self.direction[face][j];
            estimates[j] = N::Sum::new(moved.limited(self.low[j], self.high[j]));
        }
    }
}
