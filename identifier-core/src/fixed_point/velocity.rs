use super::arithmetic::{Accumulator, Word, narrow, with_product, word};
use crate::identifier::SettingsError;
use crate::measurement::velocity::{
    AveragedDifference, BackwardDifference, LowPass, Transfer, VelocityEstimate,
};
use crate::settings::{FromSettings, Settings};

/// A velocity estimate on words, as [`VelocityEstimate`] on numbers: a linear filter of unit gain, so
/// that it serves signals of any full scale.
pub trait FixedVelocity: FromSettings + Copy + core::fmt::Debug {
    /// What the filter remembers between samples.
    type State: Copy + core::fmt::Debug + Default + PartialEq;

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

impl FromSettings for FixedLowPass {
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let exact: LowPass<f64> = settings.build()?;
        Ok(Self {
            gain: word(exact.gain(), 0),
        })
    }
}

impl FixedVelocity for FixedLowPass {
    type State = Accumulator;

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

impl FromSettings for FixedAveragedDifference {
    fn from_settings(_: &Settings) -> Result<Self, SettingsError> {
        Ok(Self)
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

    fn transfer(&self) -> Transfer {
        AveragedDifference::<f64>::new().transfer()
    }
}
