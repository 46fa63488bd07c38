//! Full scales of the signals of a loop in fixed point.

use crate::constants::encode;
use crate::number::Arithmetic;
use crate::parameters::Parameter;

/// The exponents of the full scales, machine units: a word w of a quantity means w · 2^exponent. In floating point they
/// say nothing.
///
/// They follow from the settings alone, so that controller and identifier built from the same settings have the same.
/// With them every sum stays below one, and every product needs a shift in one direction only. See the table of
/// `fixed_point`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FullScales {
    /// Position error and output error.
    pub(crate) position: i32,
    /// Velocities, increments and, per sample, accelerations.
    pub(crate) velocity: i32,
    /// Commands.
    pub(crate) command: i32,
}

encode! {
    [] FullScales as "FullScales" { position, velocity, command }
}

/// Least and largest difference of the exponents of a sum and of what is added to it.
pub(crate) const APART: (i32, i32) = (2, 32);

impl FullScales {
    /// Of floating point.
    pub(crate) const NONE: Self = Self {
        position: 0,
        velocity: 0,
        command: 0,
    };

    /// The exponent of â T: its words are fractions of a quarter.
    pub(crate) const RATE: i32 = -2;

    /// Half of the command's full scale: the largest command that may act, command units.
    pub(crate) fn most_command(&self) -> f64 {
        power(self.command - 1)
    }

    /// The exponent of ε̇: servo and model may move in opposite directions.
    pub(crate) fn rate(&self) -> i32 {
        self.velocity + 1
    }

    /// The exponent of y = μ ε + ε̇, for μ in machine units.
    pub(crate) fn output(&self, mu: f64) -> i32 {
        (self.rate() + APART.0).max(least(mu, self.position))
    }

    /// The exponent of an estimate.
    pub(crate) fn estimate(&self, parameter: Parameter) -> i32 {
        match parameter {
            Parameter::A => Self::RATE,
            Parameter::B => self.velocity - self.command,
            Parameter::Coulomb | Parameter::Load => self.velocity,
        }
    }

    /// The exponent of a parameter's entry of the regressor (9).
    pub(crate) fn regressor(&self, parameter: Parameter) -> i32 {
        match parameter {
            Parameter::A => self.velocity,
            Parameter::B => self.command,
            Parameter::Coulomb | Parameter::Load => 0,
        }
    }

    /// A value in machine units as an estimate.
    pub(crate) fn estimate_of<N: Arithmetic>(&self, parameter: Parameter, value: f64) -> N {
        N::signal(value, self.estimate(parameter))
    }
}

/// The exponent of the smallest power of two that is above a magnitude; the magnitude must be
/// finite. That of zero and of subnormal numbers is the lowest of all.
pub(crate) fn exponent_above(magnitude: f64) -> i32 {
    /// Fraction bits of a double, and the exponent of the numbers from one to two.
    const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;
    const BIAS: i32 = f64::MAX_EXP - 1;
    // Not `frexp`, which calls itself: a chip's stack would have no bound.
    match (magnitude.to_bits() >> FRACTION & 0x7ff) as i32 {
        0 => -60,
        biased => biased - BIAS + 1,
    }
}

/// 2^exponent.
pub(crate) fn power(exponent: i32) -> f64 {
    libm::ldexp(1.0, exponent)
}

/// The least exponent of an output for which a factor stays below half of it.
pub(crate) fn least(factor: f64, from: i32) -> i32 {
    exponent_above(factor) + from + 1
}

#[cfg(test)]
mod tests {
    use super::exponent_above;

    #[test]
    fn the_power_above_is_the_smallest() {
        for (magnitude, exponent) in [
            (1.0, 1),
            (-1.0, 1),
            (0.999, 0),
            (0.75, 0),
            (2.0, 2),
            (3.9, 2),
            (-5.0, 3),
            (1e300, 997),
            (f64::MIN_POSITIVE, -1021),
            (0.0, -60),
        ] {
            assert_eq!(exponent_above(magnitude), exponent, "{magnitude}");
        }
    }
}
