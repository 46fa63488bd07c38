use fixed::types::I48F16;

use super::arithmetic::{FULL, Sum, WORD_BITS, Word, between, limit};
use super::pid::FixedPid;
use super::ranges::{Ranges, Scales};
use super::velocity::FixedVelocity;
use crate::error::OutOfRange;
use crate::identifier::IdentifierConfig;

/// The sampled controller on words: velocity estimate and PID.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedController<V> {
    pub(super) pid: FixedPid,
    pub(super) velocity: V,
    error: ErrorWord,
    increment: IncrementWord,
    scales: Scales,
}

/// What the controller remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedControlState<F> {
    position: i64,
    integral: Sum,
    filter: F,
}

/// One sample of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedControlSample {
    /// Position error, a fraction of its range.
    pub error: Word,
    /// Counts that the position moved since the last sample.
    pub counts: i32,
    /// The same, a fraction of the velocity's range.
    pub increment: Word,
    /// Velocity estimate, a fraction of its range.
    pub velocity: Word,
    /// The sum of errors that the command was computed with, a fraction of its range.
    pub integral: Word,
    /// The command, a fraction of its range.
    pub command: Word,
    /// Whether the integral took this sample's error.
    pub integrates: bool,
}

/// A reference in counts as the controller takes it, to the nearest 2⁻¹⁶, saturated; zero for what is
/// no number.
#[must_use]
pub fn reference_of_counts(counts: f64) -> I48F16 {
    I48F16::from_bits(libm::rint(libm::ldexp(counts, 16)) as i64)
}

impl<V: FixedVelocity> FixedController<V> {
    /// The controller for these ranges.
    ///
    /// # Errors
    /// The range that does not fit, and the one that would.
    pub fn new(
        config: &IdentifierConfig,
        ranges: &Ranges,
        velocity: V,
    ) -> Result<Self, OutOfRange> {
        let scales = Scales::new(config, ranges)?;
        Ok(Self {
            pid: FixedPid::new(config, &scales),
            velocity,
            error: ErrorWord::new(&scales),
            increment: IncrementWord::new(&scales),
            scales,
        })
    }

    /// At rest at a count, integral empty.
    #[must_use]
    pub fn start(&self, position: i64) -> FixedControlState<V::State> {
        FixedControlState {
            position,
            integral: Sum::ZERO,
            filter: V::State::default(),
        }
    }

    /// One sample: the reference in counts with 16 fraction bits, and the count. Both may be any
    /// number of turns away: only differences enter.
    #[inline]
    pub fn process(
        &self,
        state: &mut FixedControlState<V::State>,
        reference: I48F16,
        position: i64,
    ) -> FixedControlSample {
        let error = self.error.of(reference.to_bits(), position);
        let moved = position.wrapping_sub(state.position);
        state.position = position;
        let counts = nearest(moved);
        let increment = self.increment.of(counts);
        let velocity = self.velocity.process(&mut state.filter, increment);
        let integral = state.integral.word();
        let command = self.pid.command(error, velocity, integral);
        if command.integrates {
            self.pid.gather(&mut state.integral, error);
        }
        FixedControlSample {
            error,
            counts,
            increment,
            velocity,
            integral,
            command: command.value,
            integrates: command.integrates,
        }
    }

    /// The command as a number, command units.
    #[must_use]
    pub fn command(&self, sample: &FixedControlSample) -> f64 {
        super::arithmetic::value(sample.command, self.scales.command)
    }

    /// The velocity estimate as a number, counts per sample.
    #[must_use]
    pub fn velocity(&self, sample: &FixedControlSample) -> f64 {
        super::arithmetic::value(sample.velocity, self.scales.velocity)
    }
}

/// Reference less position as a word.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ErrorWord {
    exponent: u32,
}

impl ErrorWord {
    /// Fraction bits of a reference.
    const FRACTION: u32 = 16;

    fn new(scales: &Scales) -> Self {
        Self {
            exponent: scales.position.clamp(0, WORD_BITS).unsigned_abs(),
        }
    }

    /// Saturated.
    #[inline]
    fn of(self, reference: i64, position: i64) -> Word {
        const FRACTION: u32 = ErrorWord::FRACTION;
        let full = 1_i32 << self.exponent;
        // A reference has 48 bits: only a count that is 2⁶³ away itself could wrap.
        let whole = nearest((reference >> FRACTION).wrapping_sub(position));
        if whole >= full {
            return FULL;
        }
        if whole < -full {
            return -FULL;
        }
        // Within ±2^exponent counts, and a fraction of a count below 2^16.
        let whole = whole << (WORD_BITS.unsigned_abs() - self.exponent);
        let part =
            (reference as u32 & ((1 << FRACTION) - 1)) << (WORD_BITS.unsigned_abs() - FRACTION);
        limit(Word::from_bits(whole + (part >> self.exponent) as i32))
    }
}

/// x, saturated.
#[inline]
fn nearest(x: i64) -> i32 {
    let low = x as i32;
    if i64::from(low) == x {
        low
    } else if x < 0 {
        i32::MIN
    } else {
        i32::MAX
    }
}

/// Counts as a word of the velocity's full scale.
#[derive(Debug, Clone, Copy, PartialEq)]
struct IncrementWord {
    most: i32,
    up: u32,
}

impl IncrementWord {
    fn new(scales: &Scales) -> Self {
        let exponent = scales.velocity.clamp(1, WORD_BITS);
        Self {
            most: (1 << exponent) - 1,
            up: (WORD_BITS - exponent).unsigned_abs(),
        }
    }

    /// Saturated.
    #[inline]
    fn of(self, counts: i32) -> Word {
        Word::from_bits(between(counts, -self.most, self.most) << self.up)
    }
}
