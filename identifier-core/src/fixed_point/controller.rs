use fixed::types::I48F16;

use super::arithmetic::{Accumulator, WORD_BITS, Word, between, limit, narrow};
use super::pid::{ErrorSum, FixedPid};
use super::ranges::{Ranges, Scales};
use super::velocity::FixedVelocity;
use crate::error::OutOfRange;
use crate::identifier::IdentifierConfig;

/// The sampled controller on words: velocity estimate and PID.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedController<V> {
    pub(super) pid: FixedPid,
    pub(super) velocity: V,
    scales: Scales,
}

/// What the controller remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedControlState<F> {
    position: i64,
    integral: ErrorSum,
    filter: F,
}

/// One sample of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedControlSample {
    /// Position error, a fraction of its range.
    pub error: Word,
    /// Counts that the position moved since the last sample.
    pub increment: i32,
    /// Velocity estimate, a fraction of its range.
    pub velocity: Accumulator,
    /// The sum of errors that the command was computed with, last bits of a position word.
    pub integral: i64,
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
            pid: FixedPid::new(config, &scales)?,
            velocity,
            scales,
        })
    }

    /// At rest at a count, integral empty.
    #[must_use]
    pub fn start(&self, position: i64) -> FixedControlState<V::State> {
        FixedControlState {
            position,
            integral: 0,
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
        let error = self.position_word(reference.to_bits(), position);
        let moved = position.wrapping_sub(state.position);
        state.position = position;
        let increment = between(moved, i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
        let velocity = self
            .velocity
            .process(&mut state.filter, self.velocity_word(increment));
        let integral = state.integral;
        let command = self.pid.command(error, narrow(velocity), integral);
        if command.integrates {
            self.pid.gather(&mut state.integral, error);
        }
        FixedControlSample {
            error,
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
        libm::ldexp(sample.velocity.to_num::<f64>(), self.scales.velocity)
    }

    /// Reference less position, saturated.
    #[inline]
    fn position_word(&self, reference: i64, position: i64) -> Word {
        const FRACTION: u32 = 16;
        let error =
            reference.saturating_sub(super::arithmetic::saturating_left(position, FRACTION));
        scaled(error, WORD_BITS - self.scales.position - 16)
    }

    /// Counts per sample, saturated.
    #[inline]
    fn velocity_word(&self, increment: i32) -> Word {
        scaled(i64::from(increment), WORD_BITS - self.scales.velocity)
    }
}

/// An integer times 2^left as a word, saturated at ±1.
#[inline]
fn scaled(x: i64, left: i32) -> Word {
    use super::arithmetic::{between, rounded_right, saturating_left};
    let bits = if left >= 0 {
        saturating_left(x, left.unsigned_abs())
    } else {
        rounded_right(x, left.unsigned_abs())
    };
    let one = i64::from(Word::ONE.to_bits());
    limit(Word::from_bits(between(bits, -one, one) as i32))
}
