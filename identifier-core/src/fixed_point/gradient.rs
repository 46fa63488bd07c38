use super::arithmetic::{
    Accumulator, Coefficient, WORD_BITS, Word, accumulator, between, exponent_above, narrow, power,
    product, quotient, shifted, word, word_product,
};
use super::ranges::Scales;
use crate::adaptation::{Gradient, GradientUpdate};
use crate::error::{Allowed, OutOfRange};
use crate::identifier::{GradientLaw, IdentifierConfig};
use crate::parameters::ParameterSet;

/// The Γ-gradient law (11) on words, with the guard and the projection of [`Gradient`], for a
/// diagonal Γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedGradient<const P: usize> {
    gamma: [Entry; P],
    mu: Coefficient,
    strongest: Word,
    low: [Accumulator; P],
    high: [Accumulator; P],
}

/// What the diagonal of Γ does for one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Entry {
    gamma: Word,
    /// To the common full scale of φᵀΓφ.
    to_strength: i32,
    /// To the estimate's full scale.
    to_step: i32,
}

impl<const P: usize> FixedGradient<P> {
    /// Bits that the guard's bound keeps below the full scale of φᵀΓφ.
    const GUARD_BITS: i32 = WORD_BITS - 8;

    pub(super) fn new<S: ParameterSet<P>>(
        config: &IdentifierConfig,
        law: &GradientLaw<P>,
        scales: &Scales,
    ) -> Result<Self, OutOfRange> {
        let units = &config.units;
        let entries = law.gamma.entries();
        for (i, row) in entries.iter().enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                if i != j {
                    Allowed::Within(0.0, 0.0).check("gamma", entry)?;
                }
            }
        }
        let machine: [f64; P] = core::array::from_fn(|i| {
            if law.frozen[i] {
                0.0
            } else {
                let scale = S::PARAMETERS[i].scale(units) / units.velocity();
                entries[i][i] * scale * scale
            }
        });
        let own = machine.map(exponent_above);
        let strength_of = |i: usize| own[i] + 2 * scales.regressor(S::PARAMETERS[i]);
        // Two bits for the sum of up to four.
        let strength = (0..P).map(strength_of).max().unwrap_or(0) + 2;
        let bound = Gradient::<f64, P>::GUARD
            * config.assumed_box().slowest_decay(config.gains.kd())
            * units.rate();
        let least = power(strength - Self::GUARD_BITS);
        if bound < least {
            let largest = (0..P).max_by_key(|&i| strength_of(i)).unwrap_or(0);
            let given = entries[largest][largest];
            Allowed::PositiveUpTo(given * bound / least).check("gamma", given)?;
        }
        let mu = law.mu(config) * units.rate();
        let mu_by_error = Coefficient::new(mu, scales.position, scales.velocity);
        if !mu_by_error.is_felt() {
            let least = mu / units.rate() * power(scales.velocity - scales.position - 20);
            Allowed::AtLeast(least).check("mu", mu / units.rate())?;
        }
        let estimate = |i: usize, value: f64| {
            let parameter = S::PARAMETERS[i];
            accumulator(value * parameter.scale(units), scales.of(parameter))
        };
        let bounds = S::PARAMETERS.map(|parameter| config.bounds.of(parameter));
        Ok(Self {
            gamma: core::array::from_fn(|i| {
                let parameter = S::PARAMETERS[i];
                let regressor = scales.regressor(parameter);
                Entry {
                    gamma: word(machine[i], own[i]),
                    to_strength: strength_of(i) - strength,
                    to_step: own[i] + regressor + scales.velocity - scales.of(parameter),
                }
            }),
            mu: mu_by_error,
            strongest: word(bound.min(power(strength)), strength),
            low: core::array::from_fn(|i| estimate(i, bounds[i].min())),
            high: core::array::from_fn(|i| estimate(i, bounds[i].max())),
        })
    }

    /// One update from the regressor φ, the output error ε and its rate ε̇.
    #[inline]
    pub(super) fn update(
        &self,
        estimates: &mut [Accumulator; P],
        regressor: &[Word; P],
        output_error: Word,
        output_error_rate: Accumulator,
    ) -> GradientUpdate {
        let direction: [Word; P] =
            core::array::from_fn(|i| word_product(self.gamma[i].gamma, regressor[i]));
        let strength = narrow((0..P).fold(Accumulator::ZERO, |sum, i| {
            sum.saturating_add(shifted(
                product(regressor[i], direction[i]),
                self.gamma[i].to_strength,
            ))
        }));
        let mut output = narrow(
            self.mu
                .apply(output_error)
                .saturating_add(output_error_rate),
        );
        let mut update = GradientUpdate::Full;
        if strength > self.strongest {
            output = narrow(product(output, quotient(self.strongest, strength)));
            update = GradientUpdate::Slowed;
        }
        for i in 0..P {
            let step = shifted(product(direction[i], output), self.gamma[i].to_step);
            estimates[i] = between(estimates[i].saturating_sub(step), self.low[i], self.high[i]);
        }
        update
    }
}
