use crate::covariance::Covariance;
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::number::{Number, RunningSum};

/// Recursive least squares with forgetting factor for y = θᵀφ + noise, P parameters (Nelles,
/// Nonlinear System Identification, 2001, section 3.2), its covariance in the factors of
/// [`Covariance`].
///
/// Forgetting never makes a direction less certain than at the start, so that it may run without excitation
/// for any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recursion<N, const P: usize> {
    noise: N,
    growth: N,
    initial: [f64; P],
    prior: [N; P],
}

/// Configuration of a [`Recursion`], machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RecursionConfig<const P: usize> {
    /// Forgetting factor, above 0 and at most 1.
    pub(super) forgetting: f64,
    /// Standard deviation of the noise in y.
    pub(super) noise: f64,
    /// Initial estimates.
    pub(super) initial: [f64; P],
    /// Their standard deviations, above zero.
    pub(super) uncertainty: [f64; P],
}

/// State of a recursive least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RecursionState<N: Number, const P: usize> {
    estimates: [N::Sum; P],
    covariance: Covariance<N, P>,
}

impl<N: Number, const P: usize> Recursion<N, P> {
    pub(super) fn new(config: &RecursionConfig<P>) -> Result<Self, OutOfRange> {
        Allowed::PositiveUpTo(1.0).check("forgetting", config.forgetting)?;
        for value in config.initial {
            Allowed::Finite.check("initial", value)?;
        }
        for value in config.uncertainty {
            Allowed::Above(0.0).check("uncertainty", value)?;
        }
        Ok(Self {
            noise: N::from_f64(config.forgetting * config.noise * config.noise),
            growth: N::from_f64(1.0 / config.forgetting),
            initial: config.initial,
            prior: config
                .uncertainty
                .map(|deviation| N::from_f64(deviation * deviation)),
        })
    }

    pub(super) fn start(&self) -> RecursionState<N, P> {
        RecursionState {
            estimates: self.initial.map(|value| N::Sum::new(N::from_f64(value))),
            covariance: Covariance::diagonal(self.prior.map(N::to_f64)),
        }
    }

    /// θ̂ᵀφ.
    #[inline]
    pub(super) fn predict(state: &RecursionState<N, P>, regressor: &[N; P]) -> N {
        (0..P).fold(N::ZERO, |sum, i| {
            sum + state.estimates[i].value() * regressor[i]
        })
    }

    /// Updates with y and its regressor φ.
    #[inline]
    pub(super) fn update(&self, state: &mut RecursionState<N, P>, regressor: &[N; P], measured: N) {
        let error = measured - Self::predict(state, regressor);
        let innovation = state.covariance.measure(regressor, |_| self.noise);
        state.covariance.forget(self.growth, &self.prior);
        for (estimate, gain) in state.estimates.iter_mut().zip(innovation.gain) {
            estimate.add(gain * error);
        }
    }

    pub(super) fn estimates(state: &RecursionState<N, P>) -> [f64; P] {
        state.estimates.map(|sum| sum.value().to_f64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> RecursionConfig<2> {
        RecursionConfig {
            forgetting: 0.99,
            noise: 0.1,
            initial: [0.0, 0.0],
            uncertainty: [10.0, 10.0],
        }
    }

    #[test]
    fn finds_a_line_and_keeps_it_without_excitation() {
        let law = Recursion::<f32, 2>::new(&config()).expect("valid");
        let mut state = law.start();
        for k in 0..200 {
            let x = (k % 7) as f32;
            law.update(&mut state, &[x, 1.0], 3.0 * x - 2.0);
        }
        for _ in 0..1_000_000 {
            law.update(&mut state, &[0.0, 0.0], 0.0);
        }
        let [slope, offset] = Recursion::estimates(&state);
        assert!((slope - 3.0).abs() < 1e-3 && (offset + 2.0).abs() < 1e-3);
        law.update(&mut state, &[1.0, 1.0], 1.0);
        assert!(Recursion::estimates(&state).iter().all(|x| x.is_finite()));
    }
}
