use super::config::{GradientConfig, LawScales};
use super::projection::Projection;
use crate::constants::encode;
use crate::error::{Allowed, OutOfRange};
use crate::number::{Arithmetic, Encoded};
use crate::parameters::Parameter;
use crate::scales::{FullScales, power};
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
///
/// Γ is diagonal. In fixed point Γφ has a scale at which its product with y has the estimate's last bits. Where Γφ asks
/// for more, y is raised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gradient<N: Arithmetic, const P: usize> {
    /// The diagonal of Γ.
    gamma: [N::Factor; P],
    mu: N::Factor,
    /// From ε̇ to the scale of y.
    to_output: N::Shift,
    /// From φᵢ Γᵢφᵢ to the common scale of φᵀΓφ.
    to_strength: [N::Shift; P],
    strongest: N,
    strongest_per_gain: N::Factor,
    /// The shift of y before it acts on an estimate, and the largest y that each of them leaves a word.
    raise: [N::Shift; P],
    small: N,
    /// The range of the estimates.
    pub(crate) projection: Projection<N, P>,
}

encode! {
    [N: Encoded, const P: usize] Gradient<N, P> as "Gradient" {
        gamma, mu, to_output, to_strength, strongest, strongest_per_gain, raise, small, projection,
    }
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

impl<N: Arithmetic, const P: usize> GradientStep<N, P> {
    /// True if the guard leaves the whole step; false for NaN.
    #[inline(always)]
    pub(crate) fn is_gentle(&self) -> bool {
        // Where ε or ε̇ is infinite or NaN the regressor is too, and the comparison is false.
        self.strength <= self.strongest
    }
}

impl<N: Arithmetic, const P: usize> Gradient<N, P> {
    /// ρ: the largest T φᵀΓφ/α_min. At 0.05 no servo of the paper's parameter range diverges under any Γ; at 0.3 some
    /// do.
    pub(crate) const GUARD: f64 = 0.05;

    /// The estimator from its configuration.
    ///
    /// # Errors
    /// `mu` and the smallest α, or `decay_per_gain` in its place, must be positive. In fixed point a Γ or a μ that does
    /// not fit.
    pub(crate) fn new(config: &GradientConfig<P>, scales: &FullScales) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("mu", config.mu)?;
        let per_gain = config.decay_per_gain;
        Allowed::AtLeast(0.0).check("alpha_min", config.slowest_decay)?;
        Allowed::AtLeast(0.0).check("alpha_min", per_gain)?;
        Allowed::Above(0.0).check("alpha_min", config.slowest_decay + per_gain)?;
        let [known, per_gain] = [config.slowest_decay, per_gain].map(|decay| Self::GUARD * decay);
        let of = LawScales::new(config, scales, per_gain);
        let LawScales {
            output, strength, ..
        } = of;
        let (mut low, mut high) = ([N::ZERO; P], [N::ZERO; P]);
        let own = config.parameters.into_iter().zip(config.bounds);
        for ((parameter, bounds), (low, high)) in own.zip(low.iter_mut().zip(&mut high)) {
            let mut inwards = 0.0;
            if N::IS_FIXED {
                let last_bit = power(scales.estimate(parameter) - 30);
                if bounds.max() - bounds.min() > last_bit {
                    inwards = 0.5 * last_bit;
                }
            }
            *low = scales.estimate_of(parameter, bounds.min() + inwards);
            *high = scales.estimate_of(parameter, bounds.max() - inwards);
        }
        let furthest = of.up.into_iter().fold(0, i32::max);
        // However small b̂ becomes, in fixed point something is left to leave it with.
        let strongest = if N::IS_FIXED {
            known.min(power(strength)).max(power(strength - 30))
        } else {
            known
        };
        let gamma = config.moving_gamma();
        let law = Self {
            gamma: core::array::from_fn(|i| N::factor(gamma[i], of.regressor[i], of.directed[i])),
            mu: N::factor(config.mu, scales.position, output),
            to_output: N::lower(output - scales.rate()),
            to_strength: core::array::from_fn(|i| {
                N::lower(strength - of.directed[i] - of.regressor[i] - 2)
            }),
            strongest: N::signal(strongest, strength),
            strongest_per_gain: N::factor(per_gain, scales.estimate(Parameter::B), strength),
            raise: of.up.map(N::raise),
            small: N::most_raised(furthest.min(LawScales::<P>::FURTHEST)),
            projection: Projection::new(low, high),
        };
        if N::IS_FIXED {
            let at_start = known + per_gain * config.initial_gain;
            of.check::<N>(config, (&law.gamma, law.mu), scales, at_start)?;
        }
        Ok(law)
    }

    /// Which of the estimates are at a bound.
    pub(crate) fn at_bounds(&self, estimates: &[N; P]) -> [bool; P] {
        self.projection.at_bounds(estimates)
    }

    /// The update from the regressor ψ = −φ, the output error ε, its rate ε̇ and the present estimate b̂. All are in
    /// machine units.
    #[inline(always)]
    #[must_use]
    pub(crate) fn update(
        &self,
        regressor: &[N; P],
        output_error: N,
        output_error_rate: N,
        gain: N,
    ) -> GradientStep<N, P> {
        let direction = from_fn(N::ZERO, |i| regressor[i].by(self.gamma[i]));
        // Written out: a closure would be called.
        let mut strength = regressor[0]
            .times(direction[0])
            .lowered(self.to_strength[0]);
        each::<P>(|i| {
            if i > 0 {
                let share = regressor[i].times(direction[i]);
                strength = strength + share.lowered(self.to_strength[i]);
            }
        });
        GradientStep {
            strength,
            direction,
            strongest: (self.strongest + gain.by(self.strongest_per_gain)).saturated(),
            output: output_error.by(self.mu) + output_error_rate.lowered(self.to_output),
        }
    }

    /// Adds an update within the guard.
    #[inline(always)]
    pub(crate) fn add(&self, estimates: &mut [N::Sum; P], update: &GradientStep<N, P>) {
        let (direction, output) = (update.direction, update.output);
        if !N::IS_FIXED || output.magnitude() <= self.small {
            each::<P>(|i| {
                N::gather_product(&mut estimates[i], direction[i], output, self.raise[i]);
            });
        } else {
            self.add_far(estimates, direction, output);
        }
    }

    /// The step for a y that is no word when it is raised.
    #[cold]
    #[inline(never)]
    fn add_far(&self, estimates: &mut [N::Sum; P], direction: [N; P], output: N) {
        for i in 0..P {
            N::gather_far(&mut estimates[i], direction[i], output, self.raise[i]);
        }
    }

    /// Takes an update beyond the guard, shortened to the guard's bound: Γ is too large for the
    /// sample time. One that is not finite is not taken at all.
    pub(crate) fn shorten(&self, estimates: &mut [N::Sum; P], update: &GradientStep<N, P>) {
        if (update.strength + update.output).is_finite() {
            let shortened = update.strongest.quotient(update.strength);
            let output = update.output.part(shortened);
            self.add(estimates, &GradientStep { output, ..*update });
            self.projection.apply(estimates);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    fn law(gamma: [f64; 3], frozen: [bool; 3]) -> Gradient<f64, 3> {
        let wide = Interval::new("bounds", -1e3, 1e3).expect("ordered");
        let config = GradientConfig {
            parameters: [Parameter::A, Parameter::B, Parameter::Coulomb],
            gamma,
            given: [1.0; 3],
            initial_gain: 1.0,
            mu: 0.5,
            rate: 1.0,
            slowest_decay: 100.0,
            decay_per_gain: 0.0,
            bounds: [wide; 3],
            frozen,
        };
        Gradient::new(&config, &FullScales::NONE).expect("valid")
    }

    const GAMMA: [f64; 3] = [2.0, 1.0, 3.0];

    #[test]
    fn a_step_is_gamma_phi_y() {
        let law = law(GAMMA, [false; 3]);
        let mut state = [1.0, 2.0, 3.0];
        let phi = [0.3, -0.2, 0.5];
        let (error, rate) = (0.4, -0.1);
        let update = law.update(&phi, error, rate, 0.0);
        assert!(update.is_gentle());
        law.add(&mut state, &update);
        law.projection.apply(&mut state);
        let y = 0.5 * error + rate;
        for (i, estimate) in state.into_iter().enumerate() {
            let step = GAMMA[i] * phi[i] * y;
            assert!((estimate - ((i + 1) as f64 + step)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_frozen_parameter_is_not_moved() {
        let law = law(GAMMA, [false, true, false]);
        let mut state = [1.0, 2.0, 3.0];
        let update = law.update(&[0.25, 4.0, 0.5], 1.0, 0.0, 0.0);
        law.add(&mut state, &update);
        let expected = 2.0_f64;
        assert_eq!(
            state.map(|x: f64| x.to_bits() == expected.to_bits()),
            [false, true, false]
        );
    }

    #[test]
    fn the_guard_shortens_the_step_to_its_bound() {
        let law = law(GAMMA, [false; 3]);
        let phi = [3.0, -2.0, 5.0];
        let strength: f64 = (0..3).map(|i| GAMMA[i] * phi[i] * phi[i]).sum();
        let bound = Gradient::<f64, 3>::GUARD * 100.0;
        assert!(strength > bound, "the case is strong");
        let mut state = [0.0; 3];
        let update = law.update(&phi, 0.0, 1.0, 0.0);
        assert!(!update.is_gentle());
        law.shorten(&mut state, &update);
        // φᵀΔθ̂ is the strength that acted.
        let acted: f64 = state.iter().zip(phi).map(|(x, p)| x * p).sum();
        assert!((acted - bound).abs() < 1e-9);
    }

    #[test]
    fn a_step_that_is_not_finite_is_not_taken() {
        let law = law(GAMMA, [false; 3]);
        let mut state = [1.0; 3];
        let before = state;
        let update = law.update(&[1e200, 1e200, 0.0], 1.0, 0.0, 0.0);
        assert!(!update.is_gentle());
        law.shorten(&mut state, &update);
        assert_eq!(state.map(f64::to_bits), before.map(f64::to_bits));
    }
}
