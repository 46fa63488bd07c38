use super::arithmetic::{Accumulator, Word, narrow, with_product, word};
use crate::measurement::velocity::{AveragedDifference, BackwardDifference, LowPass};

/// A velocity estimate on words, as [`VelocityEstimate`](crate::measurement::velocity::VelocityEstimate)
/// on numbers: a linear filter of unit gain, so that it serves signals of any full scale.
pub trait FixedVelocity: Copy + core::fmt::Debug {
    /// What the filter remembers between samples.
    type State: Copy + core::fmt::Debug + Default;

    /// The filtered signal, of the same full scale as the input, which must be below it.
    fn process(&self, state: &mut Self::State, input: Word) -> Word;
}

/// [`LowPass`] on words; its state keeps 60 fraction bits, so nothing below a word's last bit is
/// lost in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedLowPass {
    gain: Word,
}

impl From<&LowPass<f64>> for FixedLowPass {
    fn from(filter: &LowPass<f64>) -> Self {
        Self {
            gain: word(filter.gain(), 0),
        }
    }
}

impl FixedVelocity for FixedLowPass {
    type State = Accumulator;

    #[inline]
    fn process(&self, state: &mut Accumulator, input: Word) -> Word {
        // Both below one, so their difference is a word with its guard bit.
        let miss = input - narrow(*state);
        *state = with_product(*state, self.gain, miss);
        narrow(*state)
    }
}

impl From<&Self> for BackwardDifference {
    fn from(filter: &Self) -> Self {
        *filter
    }
}

impl FixedVelocity for BackwardDifference {
    type State = ();

    #[inline]
    fn process(&self, (): &mut (), input: Word) -> Word {
        input
    }
}

/// [`AveragedDifference`] on words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedAveragedDifference;

impl From<&AveragedDifference<f64>> for FixedAveragedDifference {
    fn from(_: &AveragedDifference<f64>) -> Self {
        Self
    }
}

impl FixedVelocity for FixedAveragedDifference {
    type State = Word;

    #[inline]
    fn process(&self, last: &mut Word, input: Word) -> Word {
        let mean = (input >> 1) + (*last >> 1);
        *last = input;
        mean
    }
}
