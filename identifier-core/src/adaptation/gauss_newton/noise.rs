//! What is known of the noise, for honest standard errors.

use crate::number::Number;

/// The output error's square and that of the noise it was weighed with, summed over the same
/// samples. Every so often both are halved, so that the past fades and a sum never grows so large
/// that it would lose a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Balance<N> {
    error: N,
    noise: N,
    count: u32,
}

impl<N: Number> Balance<N> {
    /// Samples from one halving to the next.
    const FADING: u32 = 10_000;

    pub(super) const EMPTY: Self = Self {
        error: N::ZERO,
        noise: N::ZERO,
        count: 0,
    };

    #[inline]
    pub(super) fn observe(&mut self, square: N, noise: N) {
        self.error += square;
        self.noise += noise;
        self.count += 1;
        if self.count == Self::FADING {
            self.fade();
        }
    }

    #[cold]
    fn fade(&mut self) {
        let half = N::from_f64(0.5);
        self.error = self.error * half;
        self.noise = self.noise * half;
        self.count = 0;
    }

    /// The error's mean square over the noise's; one before the first sample.
    pub(super) fn ratio(&self) -> f64 {
        if self.noise > N::ZERO {
            self.error.to_f64() / self.noise.to_f64()
        } else {
            1.0
        }
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
