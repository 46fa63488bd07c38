//! The velocity estimates on words.

use super::arithmetic::{Accumulator, Word, narrow, with_product, word};
use crate::error::OutOfRange;
use crate::measurement::velocity::{
    AveragedDifference, BackwardDifference, LowPass, Transfer, VelocityEstimate,
};
use crate::units::Units;

/// Its state keeps 60 fraction bits, so nothing below a word's last bit is lost in it.
impl VelocityEstimate<Word> for LowPass<Word> {
    type State = Accumulator;

    fn with_cutoff(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        let exact = LowPass::<f64>::new(units, cutoff)?;
        Ok(Self {
            pole: word(exact.pole, 0),
            gain: word(exact.gain, 0),
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

impl VelocityEstimate<Word> for BackwardDifference {
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

impl VelocityEstimate<Word> for AveragedDifference<Word> {
    type State = Word;

    fn with_cutoff(_: &Units, _: f64) -> Result<Self, OutOfRange> {
        Ok(Self { half: word(0.5, 0) })
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
