use super::arithmetic::{Accumulator, Word, narrow, with_product, word};
use crate::error::OutOfRange;
use crate::measurement::velocity::{
    AveragedDifference, BackwardDifference, LowPass, Transfer, VelocityEstimate,
};
use crate::units::Units;

/// A velocity estimate on words, as [`VelocityEstimate`] on numbers: a linear filter of unit gain, so
/// that it serves signals of any full scale.
pub trait FixedVelocity: Copy + core::fmt::Debug {
    /// The filter's memory between samples.
    type State: Copy + core::fmt::Debug + Default + PartialEq;

    /// The estimate with a cut-off in rad/s; an estimate without one ignores it.
    ///
    /// # Errors
    /// `cutoff` out of range.
    fn with_cutoff(units: &Units, cutoff: f64) -> Result<Self, OutOfRange>;

    /// The filtered signal, of the same full scale as the input. The input must be within −1 and 1,
    /// and so is the output.
    fn process(&self, state: &mut Self::State, input: Word) -> Word;

    /// The filter's transfer function from increment to velocity.
    fn transfer(&self) -> Transfer;
}

/// [`LowPass`] on words; its state keeps 60 fraction bits, so nothing below a word's last bit is
/// lost in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedLowPass {
    gain: Word,
}

impl FixedVelocity for FixedLowPass {
    type State = Accumulator;

    fn with_cutoff(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        let exact = LowPass::<f64>::new(units, cutoff)?;
        Ok(Self {
            gain: word(exact.gain(), 0),
        })
    }

    #[inline]
    fn process(&self, state: &mut Accumulator, input: Word) -> Word {
        // Both within one, so their difference is a word with its guard bit.
        let miss = input - narrow(*state);
        *state = with_product(*state, self.gain, miss);
        narrow(*state)
    }

    fn transfer(&self) -> Transfer {
        let gain = self.gain.to_num::<f64>();
        Transfer {
            numerator: [0.0, gain],
            pole: 1.0 - gain,
        }
    }
}

impl FixedVelocity for BackwardDifference {
    type State = ();

    fn with_cutoff(_: &Units, _: f64) -> Result<Self, OutOfRange> {
        Ok(Self)
    }

    #[inline]
    fn process(&self, (): &mut (), input: Word) -> Word {
        input
    }

    fn transfer(&self) -> Transfer {
        VelocityEstimate::<f64>::transfer(self)
    }
}

/// [`AveragedDifference`] on words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedAveragedDifference;

impl FixedVelocity for FixedAveragedDifference {
    type State = Word;

    fn with_cutoff(_: &Units, _: f64) -> Result<Self, OutOfRange> {
        Ok(Self)
    }

    #[inline]
    fn process(&self, last: &mut Word, input: Word) -> Word {
        let mean = (input >> 1) + (*last >> 1);
        *last = input;
        mean
    }

    fn transfer(&self) -> Transfer {
        AveragedDifference::<f64>::new().transfer()
    }
}
