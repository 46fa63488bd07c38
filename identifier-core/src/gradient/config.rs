use crate::error::{Allowed, OutOfRange};
use crate::interval::Interval;
use crate::number::Arithmetic;
use crate::parameters::Parameter;
use crate::scales::{APART, FullScales, exponent_above, least, power};

/// The configuration of a [`Gradient`](super::Gradient), in machine units unless stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GradientConfig<const P: usize> {
    /// The parameters.
    pub parameters: [Parameter; P],
    /// The diagonal of Γ.
    pub gamma: [f64; P],
    /// The same in SI, for messages.
    pub given: [f64; P],
    /// μ T.
    pub mu: f64,
    /// T, s.
    pub rate: f64,
    /// Smallest α T that the servo is known to have, (a_min + b_min k_d) T; zero if nothing is known.
    pub slowest_decay: f64,
    /// Used where `slowest_decay` is zero: α T per machine unit of b̂.
    pub decay_per_gain: f64,
    /// Box of the estimates.
    pub bounds: [Interval; P],
    /// b̂ of the start.
    pub initial_gain: f64,
    /// Parameters that are known and stay at their initial values.
    pub frozen: [bool; P],
}

impl<const P: usize> GradientConfig<P> {
    /// The diagonal of Γ; zero for a frozen parameter.
    pub(super) fn moving_gamma(&self) -> [f64; P] {
        core::array::from_fn(|i| if self.frozen[i] { 0.0 } else { self.gamma[i] })
    }
}

/// The exponents of the full scales of the law in fixed point.
pub(super) struct LawScales<const P: usize> {
    pub(super) regressor: [i32; P],
    /// Of Γφ.
    pub(super) directed: [i32; P],
    /// The bits that y is raised by.
    pub(super) up: [i32; P],
    /// Of y, and of φᵀΓφ.
    pub(super) output: i32,
    pub(super) strength: i32,
}

impl<const P: usize> LawScales<P> {
    /// Bits that the guard's bound keeps below the full scale of φᵀΓφ: six are left.
    const GUARD_BITS: i32 = 24;

    /// Bits of Γφ and μ ε that must be left at full scale.
    const FELT: i32 = 10;

    /// The same of Γφ for friction and load, whose regressors are nearly always ±1.
    const FELT_WHERE_CONSTANT: i32 = 4;

    /// The most that y is raised by.
    pub(super) const FURTHEST: i32 = 28;

    /// Fraction bits of a factor's product: the word's, less its own part below one half and its sign.
    const PRODUCT_BITS: i32 = 28;

    pub(super) fn new(config: &GradientConfig<P>, scales: &FullScales, per_gain: f64) -> Self {
        let own = config.parameters;
        let output = scales.output(config.mu);
        let regressor = own.map(|of| scales.regressor(of));
        // A product of two words has two fraction bits less than a sum.
        let level = own.map(|of| scales.estimate(of) - output - 2);
        let gamma = config.moving_gamma();
        let least_of: [i32; P] = core::array::from_fn(|i| least(gamma[i], regressor[i]));
        let up: [i32; P] = core::array::from_fn(|i| (least_of[i] - level[i]).max(0));
        let directed: [i32; P] = core::array::from_fn(|i| level[i] + up[i]);
        // Two bits for a product, and two for its shift: the halves of four add up to less than one.
        let strengths = (0..P).map(|i| directed[i] + regressor[i] + 2 + APART.0);
        let per_gain = least(per_gain, scales.estimate(Parameter::B));
        Self {
            regressor,
            directed,
            up,
            output,
            strength: strengths.fold(per_gain, i32::max),
        }
    }

    /// Refuses a Γ or a μ that does not fit, with the one that would.
    pub(super) fn check<N: Arithmetic>(
        &self,
        config: &GradientConfig<P>,
        (gamma, mu): (&[N::Factor; P], N::Factor),
        scales: &FullScales,
        bound: f64,
    ) -> Result<(), OutOfRange> {
        for i in 0..P {
            let given = config.given[i];
            if self.up[i] > Self::FURTHEST {
                let most = given * power(Self::FURTHEST - self.up[i]);
                Allowed::PositiveUpTo(most).check("gamma", given)?;
            }
            let bits = match config.parameters[i] {
                Parameter::A | Parameter::B => Self::FELT,
                Parameter::Coulomb | Parameter::Load => Self::FELT_WHERE_CONSTANT,
            };
            if !config.frozen[i] && !N::is_felt(gamma[i], bits) {
                let least_of = least(config.gamma[i], self.regressor[i]);
                let short = self.directed[i] - least_of - (Self::PRODUCT_BITS - bits);
                Allowed::AtLeast(given * power(short)).check("gamma", given)?;
            }
        }
        let excess = self.strength - Self::GUARD_BITS - (exponent_above(bound) - 1);
        let strengths = (0..P).map(|i| {
            let strength = self.directed[i] + self.regressor[i];
            (strength, config.given[i], config.gamma[i])
        });
        let largest = strengths.max_by_key(|&(strength, ..)| strength);
        if let (1.., Some((_, given, machine))) = (excess, largest) {
            /// Just below a power of two.
            const BELOW: f64 = 1.0 - 1e-9;
            let most = BELOW * power(exponent_above(machine) - excess);
            Allowed::PositiveUpTo(given * (most / machine)).check("gamma", given)?;
        }
        if !N::is_felt(mu, Self::FELT) {
            let least = power(self.output - scales.position - 20) / config.rate;
            Allowed::AtLeast(least).check("mu", config.mu / config.rate)?;
        }
        Ok(())
    }
}
