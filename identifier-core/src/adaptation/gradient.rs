use super::{Gain, Projection};
use crate::constants::{Encode, encode};
use crate::error::{Allowed, OutOfRange};
use crate::interval::Interval;
use crate::linalg::{PositiveDefinite, dot};
use crate::number::{Number, RunningSum};
use crate::unrolled::{each, from_fn};

/// The Γ-gradient estimator (11), θ̂˙ = −Γ φ (μ ε + ε̇), for P parameters.
///
/// Sampled, with ψ = −φ, it is θ̂ ← Proj[θ̂ + s Γ ψ y], y = μ ε + ε̇. The guard is s = min(1, ρ α_min T / (T² φᵀΓφ)).
///
/// **Why the guard.** Near the solution the adaptation loop is s² + α s + φᵀΓφ. Sampled with T, it needs T φᵀΓφ well
/// below α = a + b k_d. The guard holds it below the fraction ρ = [`Gradient::GUARD`] of the smallest α that the servo
/// can have. (11) stays stable for every Γ > 0. A positive factor on the whole step only makes Γ smaller for that
/// sample. Without a parameter range the smallest α follows from the present estimate b̂. The widest bound would slow
/// the identification of a servo with strong damping many times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gradient<N, const P: usize> {
    gamma: Gain<N, P>,
    mu: N,
    strongest: N,
    strongest_per_gain: N,
    projection: Projection<N, P>,
}

encode! {
    [N: Encode, const P: usize] Gradient<N, P> as "Gradient" {
        gamma, mu, strongest, strongest_per_gain, projection,
    }
}

/// State of the estimator: the estimates, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GradientState<N: Number, const P: usize> {
    estimates: [N::Sum; P],
}

/// An update before it is taken, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GradientStep<N, const P: usize> {
    /// Γψ.
    direction: [N; P],
    /// ψᵀΓψ = φᵀΓφ.
    strength: N,
    /// The largest `strength` that the guard allows.
    strongest: N,
    /// y = μ ε + ε̇.
    output: N,
}

impl<N: Number, const P: usize> GradientStep<N, P> {
    /// True if the guard leaves the whole step; false for NaN.
    #[inline]
    #[must_use]
    pub(crate) fn is_gentle(&self) -> bool {
        // Where ε or ε̇ is infinite or NaN the regressor is too, and the comparison is false.
        self.strength <= self.strongest
    }
}

/// The machine-unit configuration of a [`Gradient`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GradientConfig<const P: usize> {
    /// Γ.
    pub gamma: PositiveDefinite<P>,
    /// μ T.
    pub mu: f64,
    /// Smallest α T that the servo is known to have, (a_min + b_min k_d) T; zero if nothing is known.
    pub slowest_decay: f64,
    /// Used where `slowest_decay` is zero: α T per machine unit of b̂.
    pub decay_per_gain: f64,
    /// Box of the estimates.
    pub bounds: [Interval; P],
    /// Parameters that are known and stay at their initial values.
    pub frozen: [bool; P],
}

impl<N: Number, const P: usize> GradientState<N, P> {
    /// Starts from initial estimates, machine units.
    #[must_use]
    pub(crate) fn new(estimates: [f64; P]) -> Self {
        Self {
            estimates: estimates.map(|value| N::Sum::new(N::from_f64(value))),
        }
    }

    /// The estimates, machine units.
    #[inline]
    #[must_use]
    pub(crate) fn estimates(&self) -> [N; P] {
        from_fn(N::ZERO, |i| self.estimates[i].value())
    }
}

impl<N: Number, const P: usize> Gradient<N, P> {
    /// ρ: the largest T φᵀΓφ/α_min. At 0.05 no servo of the paper's parameter range diverges under any Γ; at 0.3 some
    /// do.
    pub(crate) const GUARD: f64 = 0.05;

    /// The estimator from its configuration.
    ///
    /// # Errors
    /// `mu` and the smallest α, or `decay_per_gain` in its place, must be positive.
    pub(crate) fn new(config: &GradientConfig<P>) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("mu", config.mu)?;
        let per_gain = config.decay_per_gain;
        Allowed::AtLeast(0.0).check("alpha_min", config.slowest_decay)?;
        Allowed::AtLeast(0.0).check("alpha_min", per_gain)?;
        Allowed::Above(0.0).check("alpha_min", config.slowest_decay + per_gain)?;
        Ok(Self {
            gamma: Gain::new(&config.gamma, config.frozen),
            mu: N::from_f64(config.mu),
            strongest: N::from_f64(Self::GUARD * config.slowest_decay),
            strongest_per_gain: N::from_f64(Self::GUARD * per_gain),
            projection: Projection::new(
                config.bounds.map(|bound| bound.min()),
                config.bounds.map(|bound| bound.max()),
                &config.gamma,
            ),
        })
    }

    /// Which of the estimates are at a bound.
    #[must_use]
    pub(crate) fn at_bounds(&self, estimates: &[N; P]) -> [bool; P] {
        self.projection.at_bounds(estimates)
    }

    /// The update from the regressor ψ = −φ, the output error ε, its rate ε̇ and the present estimate b̂. All are in
    /// machine units.
    #[inline]
    #[must_use]
    pub(crate) fn update(
        &self,
        regressor: &[N; P],
        output_error: N,
        output_error_rate: N,
        gain: N,
    ) -> GradientStep<N, P> {
        let direction = self.gamma.times(regressor);
        GradientStep {
            strength: dot(regressor, &direction),
            direction,
            strongest: self.strongest + self.strongest_per_gain * gain,
            output: self.mu * output_error + output_error_rate,
        }
    }

    /// Takes an update within the guard.
    #[inline]
    pub(crate) fn take(&self, state: &mut GradientState<N, P>, update: &GradientStep<N, P>) {
        each::<P>(|i| state.estimates[i].add(update.direction[i] * update.output));
        self.projection.apply(&mut state.estimates);
    }

    /// Takes an update beyond the guard, shortened to the guard's bound: Γ is too large for the
    /// sample time. One that is not finite is not taken at all.
    pub(crate) fn shorten(&self, state: &mut GradientState<N, P>, update: &GradientStep<N, P>) {
        if (update.strength + update.output).is_finite() {
            let output = update.output * update.strongest * update.strength.reciprocal();
            self.take(state, &GradientStep { output, ..*update });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(gamma: [[f64; 3]; 3]) -> Gradient<f64, 3> {
        let wide = Interval::new("bounds", -1e3, 1e3).expect("ordered");
        let config = GradientConfig {
            gamma: PositiveDefinite::new(gamma).expect("positive definite"),
            mu: 0.5,
            slowest_decay: 100.0,
            decay_per_gain: 0.0,
            bounds: [wide; 3],
            frozen: [false; 3],
        };
        Gradient::new(&config).expect("valid")
    }

    const GAMMA: [[f64; 3]; 3] = [[2.0, 0.5, 0.0], [0.5, 1.0, 0.1], [0.0, 0.1, 3.0]];

    #[test]
    fn a_step_is_gamma_phi_y_with_a_full_gamma() {
        let law = law(GAMMA);
        let mut state = GradientState::new([1.0, 2.0, 3.0]);
        let phi = [0.3, -0.2, 0.5];
        let (error, rate) = (0.4, -0.1);
        let update = law.update(&phi, error, rate, 0.0);
        assert!(update.is_gentle());
        law.take(&mut state, &update);
        let y = 0.5 * error + rate;
        for (i, estimate) in state.estimates().into_iter().enumerate() {
            let step: f64 = (0..3).map(|j| GAMMA[i][j] * phi[j]).sum();
            assert!((estimate - ((i + 1) as f64 + step * y)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_guard_shortens_the_step_to_its_bound() {
        let law = law(GAMMA);
        let phi = [3.0, -2.0, 5.0];
        let strength: f64 = (0..3)
            .flat_map(|i| (0..3).map(move |j| phi[i] * GAMMA[i][j] * phi[j]))
            .sum();
        let bound = Gradient::<f64, 3>::GUARD * 100.0;
        assert!(strength > bound, "the case is strong");
        let mut state = GradientState::new([0.0; 3]);
        let update = law.update(&phi, 0.0, 1.0, 0.0);
        assert!(!update.is_gentle());
        law.shorten(&mut state, &update);
        // φᵀΔθ̂ is the strength that acted.
        let acted: f64 = state.estimates().iter().zip(phi).map(|(x, p)| x * p).sum();
        assert!((acted - bound).abs() < 1e-9);
    }

    #[test]
    fn a_step_that_is_not_finite_is_not_taken() {
        let law = law(GAMMA);
        let mut state = GradientState::new([1.0; 3]);
        let before = state;
        let update = law.update(&[1e200, 1e200, 0.0], 1.0, 0.0, 0.0);
        assert!(!update.is_gentle());
        law.shorten(&mut state, &update);
        assert!(state == before);
    }
}
