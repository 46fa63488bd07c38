use super::arithmetic::{
    Coefficient, Shift, Sum, WORD_BITS, Word, between, power, product, quarter_product, quotient,
    word,
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
    entries: [Entry; P],
    mu: Coefficient,
    /// From ε̇ to the scale of y.
    rate_down: u32,
    strongest: Word,
}

/// What concerns one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Entry {
    /// Γᵢᵢ.
    gamma: Coefficient,
    /// To the common full scale of φᵀΓφ.
    strength_down: u32,
    /// To the estimate's full scale.
    step: Shift,
    low: Sum,
    high: Sum,
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
        // Of Γφ: no more than half of it, and a product with y no finer than a sum can take.
        let directed = |i: usize| {
            let parameter = S::PARAMETERS[i];
            let least = Coefficient::least(machine[i], scales.regressor(parameter));
            let finest = Shift::places(least + scales.output, scales.of(parameter));
            least + (finest - Shift::FURTHEST).max(0)
        };
        let strength_of = |i: usize| directed(i) + scales.regressor(S::PARAMETERS[i]);
        // Two bits for the quarter of a product, and the halves of four add up to less than one.
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
        for (i, parameter) in S::PARAMETERS.into_iter().enumerate() {
            let up = -Shift::places(directed(i) + scales.output, scales.of(parameter));
            if up > Shift::FURTHEST {
                let most = entries[i][i] * power(Shift::FURTHEST - up);
                Allowed::PositiveUpTo(most).check("gamma", entries[i][i])?;
            }
        }
        let mu = law.mu(config);
        let mu_by_error = Coefficient::new(mu * units.rate(), scales.position, scales.output);
        if !mu_by_error.is_felt() {
            let least = power(scales.output - scales.position - 20) / units.rate();
            Allowed::AtLeast(least).check("mu", mu)?;
        }
        Ok(Self {
            entries: core::array::from_fn(|i| {
                let parameter = S::PARAMETERS[i];
                let own = scales.of(parameter);
                let bounds = config.bounds.of(parameter);
                let scale = parameter.scale(units);
                Entry {
                    gamma: Coefficient::new(machine[i], scales.regressor(parameter), directed(i)),
                    strength_down: (strength - 2 - strength_of(i)).unsigned_abs().min(31),
                    step: Shift::new(directed(i) + scales.output, own),
                    low: Sum::of(bounds.min() * scale, own),
                    high: Sum::of(bounds.max() * scale, own),
                }
            }),
            mu: mu_by_error,
            rate_down: (scales.output - scales.velocity).unsigned_abs().min(31),
            strongest: word(bound.min(power(strength)), strength),
        })
    }

    /// One update from the regressor φ, the output error ε and its rate ε̇.
    #[inline]
    pub(super) fn update(
        &self,
        estimates: &mut [Sum; P],
        regressor: &[Word; P],
        output_error: Word,
        output_error_rate: Word,
    ) -> GradientUpdate {
        let direction: [Word; P] =
            core::array::from_fn(|i| self.entries[i].gamma.apply(regressor[i]));
        let strength = (0..P).fold(Word::ZERO, |sum, i| {
            sum + (quarter_product(regressor[i], direction[i]) >> self.entries[i].strength_down)
        });
        let mut output = self.mu.apply(output_error) + (output_error_rate >> self.rate_down);
        let mut update = GradientUpdate::Full;
        if strength > self.strongest {
            output = product(output, quotient(self.strongest, strength));
            update = GradientUpdate::Slowed;
        }
        for (i, entry) in self.entries.iter().enumerate() {
            estimates[i].subtract(direction[i], output, entry.step);
            // What the halves cannot tell apart is limited exactly.
            let word = estimates[i].word();
            if word <= entry.low.word() || word >= entry.high.word() {
                estimates[i] = between(estimates[i], entry.low, entry.high);
            }
        }
        update
    }
}
