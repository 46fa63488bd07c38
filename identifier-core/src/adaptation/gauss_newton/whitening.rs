use crate::number::Number;

/// A filter on the blocks' errors and sensitivities before a law learns from them.
pub trait Whitening<N, const P: usize>: Copy + core::fmt::Debug + PartialEq {
    /// Nothing was seen yet; errors are taken as they are.
    const START: Self;

    /// True if it separates the correlated part of an error from the innovation.
    const WHITENS: bool;

    /// Begins to whiten.
    fn begin(&mut self);

    /// True if it has begun.
    fn has_begun(&self) -> bool;

    /// Takes the mean error of a block and its sensitivity, and leaves the innovation of both. `gain`
    /// is the gain of the correlation's estimate for this block; zero where the model did not move.
    fn process(&mut self, sensitivity: &mut [N; P], error: N, gain: N);

    /// The error of the last block as it is to be learnt from; `raw` is that error as it was.
    fn innovation(&self, raw: N) -> N;

    /// The estimates moved by these steps.
    fn follow(&mut self, steps: &[N; P]);

    /// The next block does not follow the last.
    fn interrupt(&mut self);
}

/// Errors are taken as they are.
impl<N: Number, const P: usize> Whitening<N, P> for () {
    const START: Self = ();
    const WHITENS: bool = false;

    fn begin(&mut self) {}

    fn has_begun(&self) -> bool {
        false
    }

    #[inline]
    fn process(&mut self, _: &mut [N; P], _: N, _: N) {}

    #[inline]
    fn innovation(&self, raw: N) -> N {
        raw
    }

    #[inline]
    fn follow(&mut self, _: &[N; P]) {}

    #[inline]
    fn interrupt(&mut self) {}
}

/// Whitening of first order, for drifting loads: of an error whose correlation over k blocks is ρᵏ
/// only ε_k − ρ ε_(k−1) is innovation, and the sensitivities are filtered alike (Ljung, System
/// Identification, 2nd edition 1999, section 7.1). ρ is learnt from the errors of a model in motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstOrder<N, const P: usize> {
    begun: bool,
    /// False before the first block and after a gap.
    follows: bool,
    error: N,
    sensitivity: [N; P],
    innovation: N,
    square: N,
    lag_one: N,
    correlation: N,
}

impl<N: Number, const P: usize> FirstOrder<N, P> {
    /// The largest correlation that is taken out: a constant load has to stay visible.
    const MAX_CORRELATION: f64 = 0.99;
}

impl<N: Number, const P: usize> Whitening<N, P> for FirstOrder<N, P> {
    const START: Self = Self {
        begun: false,
        follows: false,
        error: N::ZERO,
        sensitivity: [N::ZERO; P],
        innovation: N::ZERO,
        square: N::ZERO,
        lag_one: N::ZERO,
        correlation: N::ZERO,
    };
    const WHITENS: bool = true;

    fn begin(&mut self) {
        self.begun = true;
    }

    fn has_begun(&self) -> bool {
        self.begun
    }

    fn process(&mut self, sensitivity: &mut [N; P], error: N, gain: N) {
        let (last_error, last_sensitivity) = (self.error, self.sensitivity);
        self.error = error;
        self.sensitivity = *sensitivity;
        self.innovation = error;
        if !core::mem::replace(&mut self.follows, true) {
            return;
        }
        if gain > N::ZERO {
            self.square += gain * (error * error - self.square);
            self.lag_one += gain * (error * last_error - self.lag_one);
            if self.square > N::ZERO && self.square.reciprocal().is_finite() {
                self.correlation = (self.lag_one * self.square.reciprocal())
                    .limited(N::ZERO, N::from_f64(Self::MAX_CORRELATION));
            }
        }
        if self.begun {
            self.innovation = error - self.correlation * last_error;
            for (value, last) in sensitivity.iter_mut().zip(last_sensitivity) {
                *value = *value - self.correlation * last;
            }
        }
    }

    fn innovation(&self, _: N) -> N {
        self.innovation
    }

    fn follow(&mut self, steps: &[N; P]) {
        for i in 0..P {
            self.error = self.error - self.sensitivity[i] * steps[i];
        }
    }

    fn interrupt(&mut self) {
        self.follows = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_leaves_the_innovation_of_correlated_errors() {
        const RENEWED: f64 = 1.0 / 500.0;
        let mut whitening = FirstOrder::<f64, 1>::START;
        whitening.begin();
        let (mut error, mut innovation, mut plain) = (0.0, 0.0, 0.0);
        let mut state = 12_345_u32;
        for k in 0..20_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let white = f64::from(state) / f64::from(u32::MAX) - 0.5;
            error = 0.9 * error + white;
            let mut sensitivity = [1.0];
            whitening.process(&mut sensitivity, error, RENEWED);
            if k > 5000 {
                innovation += whitening.innovation(error).powi(2);
                plain += white.powi(2);
                assert!((sensitivity[0] - 0.1).abs() < 0.1, "{sensitivity:?}");
            }
        }
        assert!(
            (innovation / plain - 1.0).abs() < 0.02,
            "{}",
            innovation / plain
        );
    }

    #[test]
    fn nothing_is_taken_across_a_gap() {
        let mut whitening = FirstOrder::<f64, 1>::START;
        whitening.begin();
        for error in [1.0, 1.0, 1.0] {
            whitening.process(&mut [1.0], error, 0.01);
        }
        whitening.interrupt();
        let mut sensitivity = [1.0];
        whitening.process(&mut sensitivity, 5.0, 0.01);
        assert_eq!((whitening.innovation(5.0), sensitivity), (5.0, [1.0]));
    }
}
