//! What is known of the noise, for honest standard errors.

use crate::number::Number;

/// The output error's mean square and that of the noise it was weighed with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Balance<N> {
    pub(super) error: N,
    pub(super) noise: N,
    pub(super) weight: N,
}

impl<N: Number> Balance<N> {
    #[inline]
    pub(super) fn observe(&mut self, square: N, noise: N, least_weight: N) {
        self.error += self.weight * (square - self.error);
        self.noise += self.weight * (noise - self.noise);
        // 1, 1/2, 1/3, …
        let next = if self.weight > least_weight {
            self.weight * (N::ONE + self.weight).reciprocal()
        } else {
            least_weight
        };
        self.weight = next;
    }
}

/// How much the steps of an estimate add up within a batch, against steps that know nothing of each
/// other: the factor by which the noise's spectrum where it matters differs from white noise
/// (the method of batch means; Schmeiser, "Batch size effects in the analysis of simulation
/// output", Operations Research 30(3), 1982).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Batches<N, const P: usize> {
    count: u32,
    sums: [N; P],
    squares: [N; P],
    pub(super) factors: [N; P],
    pub(super) weight: N,
}

impl<N: Number, const P: usize> Batches<N, P> {
    /// Updates in a batch: longer than the loop remembers.
    const LENGTH: u32 = 512;

    /// The least weight of a batch in the mean of the batches.
    const LEAST_WEIGHT: f64 = 1.0 / 64.0;

    pub(super) fn new() -> Self {
        Self {
            count: 0,
            sums: [N::ZERO; P],
            squares: [N::ZERO; P],
            factors: [N::ONE; P],
            weight: N::ONE,
        }
    }

    #[inline]
    pub(super) fn observe(&mut self, steps: &[N; P]) {
        for i in 0..P {
            self.sums[i] += steps[i];
            self.squares[i] += steps[i] * steps[i];
        }
        self.count += 1;
        if self.count == Self::LENGTH {
            self.close();
        }
    }

    #[cold]
    fn close(&mut self) {
        for i in 0..P {
            if self.squares[i] > N::ZERO {
                // Squares of steps may be smaller than any number that has a reciprocal.
                let scale = self.squares[i].to_f64();
                let sum = self.sums[i].to_f64();
                let ratio = N::from_f64((sum * sum / scale).min(f64::from(Self::LENGTH)));
                self.factors[i] += self.weight * (ratio - self.factors[i]);
            }
        }
        let least = N::from_f64(Self::LEAST_WEIGHT);
        let next = self.weight * (N::ONE + self.weight).reciprocal();
        *self = Self {
            factors: self.factors,
            weight: if next > least { next } else { least },
            ..Self::new()
        };
    }
}
