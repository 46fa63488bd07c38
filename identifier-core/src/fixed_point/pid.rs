use super::arithmetic::{
    Accumulator, Coefficient, Word, between, exponent_above, narrow, rounded_right, word,
};
use super::ranges::Scales;
use crate::error::{Allowed, OutOfRange};
use crate::identifier::IdentifierConfig;

/// The PID (3) on words, with command limit and anti-windup as [`Pid`](crate::control::Pid) has
/// them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedPid {
    proportional: Coefficient,
    derivative: Coefficient,
    integral: Coefficient,
    /// Bits by which the sum of errors is shifted to a word.
    integral_shift: u32,
    low: Word,
    high: Word,
}

/// A sum of errors, in last bits of a position word: 64 bits, and kept within what the integral's
/// word can hold.
pub(super) type ErrorSum = i64;

/// A command and what anti-windup says of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedCommand {
    pub(super) value: Word,
    pub(super) integrates: bool,
}

impl FixedPid {
    /// Full scales of the command that the integral part may reach.
    const INTEGRAL_ROOM: f64 = 2.0;

    pub(super) fn new(config: &IdentifierConfig, scales: &Scales) -> Result<Self, OutOfRange> {
        let (units, gains) = (&config.units, &config.gains);
        let per_error = gains.ki() * units.rate() / units.position();
        // The largest sum of errors that means a command within range, as an exponent.
        let full_scale = libm::ldexp(Self::INTEGRAL_ROOM, scales.command);
        let sum = if per_error > 0.0 {
            exponent_above(full_scale / per_error).max(scales.position)
        } else {
            scales.position
        };
        let shift = sum - scales.position;
        // Below, an error of a hundredth of its range adds nothing to the integral's word.
        const LONGEST: i32 = 32;
        if shift > LONGEST {
            let least = libm::ldexp(
                full_scale * units.position() / gains.ki(),
                -LONGEST - scales.position,
            );
            Allowed::AtLeast(least).check("sample_time", units.sample_time())?;
        }
        let limited = |limit: f64| word(limit.max(-full_scale).min(full_scale), scales.command);
        Ok(Self {
            proportional: Coefficient::new(
                gains.kp() / units.position(),
                scales.position,
                scales.command,
            ),
            derivative: Coefficient::new(
                gains.kd() / units.velocity(),
                scales.velocity,
                scales.command,
            ),
            integral: Coefficient::new(per_error, sum, scales.command),
            integral_shift: shift.unsigned_abs(),
            low: limited(config.limit.low()),
            high: limited(config.limit.high()),
        })
    }

    /// u = kp e − kd v + ki ∑e, limited.
    #[inline]
    pub(super) fn command(&self, error: Word, velocity: Word, sum: ErrorSum) -> FixedCommand {
        let wanted = narrow(
            self.proportional
                .apply(error)
                .saturating_sub(self.derivative.apply(velocity))
                .saturating_add(self.integral_command(sum)),
        );
        if wanted > self.high {
            FixedCommand {
                value: self.high,
                integrates: error <= Word::ZERO,
            }
        } else if wanted < self.low {
            FixedCommand {
                value: self.low,
                integrates: error >= Word::ZERO,
            }
        } else {
            FixedCommand {
                value: wanted,
                integrates: true,
            }
        }
    }

    /// kd v.
    #[inline]
    pub(super) fn damping(&self, velocity: Word) -> Accumulator {
        self.derivative.apply(velocity)
    }

    /// ki ∑.
    #[inline]
    pub(super) fn integral_command(&self, sum: ErrorSum) -> Accumulator {
        // Within ±2³⁰ by [`FixedPid::gather`].
        let bits = rounded_right(sum, self.integral_shift);
        let one = i64::from(Word::ONE.to_bits());
        self.integral
            .apply(Word::from_bits(between(bits, -one, one) as i32))
    }

    /// Adds an error to a sum, which stops at its full scale.
    #[inline]
    pub(super) fn gather(&self, sum: &mut ErrorSum, error: Word) {
        let most = i64::from(Word::ONE.to_bits()) << self.integral_shift;
        *sum = between(sum.saturating_add(i64::from(error.to_bits())), -most, most);
    }
}
