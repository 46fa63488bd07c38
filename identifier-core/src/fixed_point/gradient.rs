use super::arithmetic::{
    Coefficient, Raise, Sum, WORD_BITS, Word, between, limit, power, product, quarter_product,
    quotient, word,
};
use super::ranges::FullScales;
use crate::adaptation::Gradient;
use crate::constants::encode;
use crate::error::{Allowed, OutOfRange};
use crate::parameters::{Parameter, ParameterSet};
use crate::settings::{Decay, GradientPlan};
use crate::unrolled::{each, from_fn};

/// The Γ-gradient estimator (11) on words, with the guard and the projection of
/// [`Gradient`](crate::adaptation::Gradient), for a diagonal Γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedGradient<const P: usize> {
    entries: [Entry; P],
    mu: Coefficient,
    /// From ε̇ to the scale of y.
    rate_down: u32,
    strongest: Word,
    strongest_per_gain: Coefficient,
    /// The largest y that is still a word when it is raised for any of the estimates.
    small: Word,
}

encode! {
    [const P: usize] FixedGradient<P> as "FixedGradient" {
        entries, mu, rate_down, strongest, strongest_per_gain, small,
    }
}

/// Gain and bounds of one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Entry {
    /// Γᵢᵢ.
    gamma: Coefficient,
    /// The shift of y before it acts on the estimate.
    up: Raise,
    /// Γᵢᵢ again, to a quarter of the common full scale of φᵀΓφ once more times φᵢ.
    strength: Coefficient,
    low: Sum,
    high: Sum,
    /// The distance of the high halves of the two bounds, in last bits.
    between: u32,
}

encode! {
    [] Entry as "Entry" { gamma, up, strength, low, high, between }
}

impl Entry {
    /// Moves an estimate back to its bounds.
    #[inline]
    fn project(&self, estimate: &mut Sum) {
        let above = estimate
            .word()
            .to_bits()
            .wrapping_sub(self.low.word().to_bits());
        // Values that the high halves do not distinguish are limited exactly.
        if above.wrapping_sub(1).cast_unsigned() >= self.between {
            *estimate = between(*estimate, self.low, self.high);
        }
    }
}

impl<const P: usize> FixedGradient<P> {
    /// Bits that the guard's bound keeps below the full scale of φᵀΓφ.
    const GUARD_BITS: i32 = WORD_BITS - 8;

    /// Bits of Γφ and μ ε that must be left at full scale.
    const FELT: i32 = 10;

    /// The same of Γφ for friction and load, whose regressors are nearly always ±1.
    const FELT_WHERE_CONSTANT: i32 = 4;

    /// The most that y is raised by.
    const FURTHEST: i32 = 28;

    pub(super) fn new<S: ParameterSet<P>>(
        plan: &GradientPlan<P>,
        scales: &FullScales,
    ) -> Result<Self, OutOfRange> {
        let units = &plan.units;
        let given = plan.gamma.entries();
        let machine: [f64; P] = core::array::from_fn(|i| {
            if plan.frozen[i] {
                0.0
            } else {
                let scale = S::PARAMETERS[i].scale(units) / units.velocity();
                given[i][i] * scale * scale
            }
        });
        let mu = plan.mu * units.rate();
        let output = scales.output(mu);

        // Where Γφ times y has the estimate's last bits; where Γφ asks for more, y is raised.
        let level = S::PARAMETERS.map(|of| Sum::exponent_of_factor(scales.estimate(of), output));
        let regressor = S::PARAMETERS.map(|of| scales.regressor(of));
        let least: [i32; P] =
            core::array::from_fn(|i| Coefficient::least(machine[i], regressor[i]));
        let up: [i32; P] = core::array::from_fn(|i| (least[i] - level[i]).max(0));
        let directed: [i32; P] = core::array::from_fn(|i| level[i] + up[i]);
        let bits = |i: usize| match S::PARAMETERS[i] {
            Parameter::A | Parameter::B => Self::FELT,
            Parameter::Coulomb | Parameter::Load => Self::FELT_WHERE_CONSTANT,
        };
        let gamma: [Coefficient; P] =
            core::array::from_fn(|i| Coefficient::new(machine[i], regressor[i], directed[i]));
        for i in 0..P {
            let given = given[i][i];
            if up[i] > Self::FURTHEST {
                let most = given * power(Self::FURTHEST - up[i]);
                Allowed::PositiveUpTo(most).check("gamma", given)?;
            }
            if !plan.frozen[i] && !gamma[i].is_felt(bits(i)) {
                let least = given * power(directed[i] - least[i] - (WORD_BITS - 2 - bits(i)));
                Allowed::AtLeast(least).check("gamma", given)?;
            }
        }

        let (known, per_gain) = match plan.decay {
            Decay::Known(decay) => (decay * units.rate(), 0.0),
            Decay::PerGain(per_gain) => (0.0, per_gain * units.rate() / units.acceleration()),
        };
        let [known, per_gain] = [known, per_gain].map(|decay| Gradient::<f64, P>::GUARD * decay);
        let gain = scales.estimate(Parameter::B);
        let strengths: [i32; P] = core::array::from_fn(|i| directed[i] + regressor[i]);
        // Two bits for the quarter of a product, and the halves of four add up to less than one.
        let strength = strengths.into_iter().max().unwrap_or(0) + 2;
        let strength = strength.max(Coefficient::least(per_gain, gain));
        // Where it follows from b̂, that of the start.
        let started = S::PARAMETERS.iter().zip(plan.initial);
        let started: f64 = started
            .map(|(&parameter, initial)| match parameter {
                Parameter::B => initial * parameter.scale(units),
                _ => 0.0,
            })
            .sum();
        let bound = known + per_gain * started;
        let least = power(strength - Self::GUARD_BITS);
        if bound < least {
            let entries = (0..P).map(|i| (strengths[i], given[i][i]));
            let largest = entries.max_by_key(|&(strength, _)| strength);
            let given = largest.map_or(0.0, |(_, given)| given);
            Allowed::PositiveUpTo(given * bound / least).check("gamma", given)?;
        }

        let furthest = up.into_iter().max().unwrap_or(0).min(Self::FURTHEST);
        let mu_by_error = Coefficient::new(mu, scales.position, output);
        if !mu_by_error.is_felt(Self::FELT) {
            let least = power(output - scales.position - 20) / units.rate();
            Allowed::AtLeast(least).check("mu", plan.mu)?;
        }
        Ok(Self {
            entries: core::array::from_fn(|i| {
                let parameter = S::PARAMETERS[i];
                let own = scales.estimate(parameter);
                let bounds = plan.bounds[i].scaled(parameter.scale(units));
                let (low, high) = (
                    Sum::from_value(bounds.min(), own),
                    Sum::from_value(bounds.max(), own),
                );
                let apart = high.word().to_bits().wrapping_sub(low.word().to_bits());
                Entry {
                    gamma: gamma[i],
                    up: Raise::by(up[i]),
                    strength: Coefficient::new(
                        machine[i],
                        scales.regressor(parameter),
                        strength - 2 - scales.regressor(parameter),
                    ),
                    low,
                    high,
                    between: apart.cast_unsigned().saturating_sub(1),
                }
            }),
            mu: mu_by_error,
            rate_down: (output - scales.rate()).unsigned_abs().min(31),
            // However small b̂ becomes, something is left to leave it with.
            strongest: word(known.min(power(strength)), strength).max(Word::DELTA),
            strongest_per_gain: Coefficient::new(per_gain, gain, strength),
            small: Raise::by(furthest).most(),
        })
    }

    /// One update from the regressor φ, the output error ε and its rate ε̇, for the present estimate b̂. True if the
    /// guard shortened it.
    #[inline]
    pub(super) fn update(
        &self,
        estimates: &mut [Sum; P],
        regressor: &[Word; P],
        output_error: Word,
        output_error_rate: Word,
        gain: Word,
    ) -> bool {
        let direction: [Word; P] =
            from_fn(Word::ZERO, |i| self.entries[i].gamma.apply(regressor[i]));
        let mut strength = Word::ZERO;
        each::<P>(|i| {
            let direction = self.entries[i].strength.apply(regressor[i]);
            strength += quarter_product(regressor[i], direction);
        });
        let mut output = self.mu.apply(output_error) + (output_error_rate >> self.rate_down);
        let strongest = limit(self.strongest + self.strongest_per_gain.apply(gain));
        let slowed = strength > strongest;
        if slowed {
            output = product(output, quotient(strongest, strength));
        }
        if output <= self.small && output >= -self.small {
            each::<P>(|i| {
                estimates[i].add_product(direction[i], self.entries[i].up.apply(-output));
            });
        } else {
            self.step_far(estimates, direction, output);
        }
        each::<P>(|i| self.entries[i].project(&mut estimates[i]));
        slowed
    }

    /// The step for a y that is no word when it is raised.
    #[cold]
    #[inline(never)]
    fn step_far(&self, estimates: &mut [Sum; P], direction: [Word; P], output: Word) {
        for i in 0..P {
            estimates[i].add_product_raised(direction[i], -output, self.entries[i].up);
        }
    }

    /// Which estimates are at a bound.
    pub(super) fn at_bounds(&self, estimates: &[Sum; P]) -> [bool; P] {
        core::array::from_fn(|i| {
            let (estimate, entry) = (estimates[i], &self.entries[i]);
            estimate <= entry.low || estimate >= entry.high
        })
    }
}
