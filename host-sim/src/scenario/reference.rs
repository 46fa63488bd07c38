//! The reference signal, chosen at run time.

use identifier_core::error::OutOfRange;
use identifier_core::excitation::{Excitation, Prbs, PrbsState};
use identifier_core::number::Number;
use identifier_core::units::Units;
use virtual_servo::excitation::{
    BandLimitedWhiteNoise, BandLimitedWhiteNoiseState, Chirp, ChirpState, Multisine,
    MultisineState, Square, SquareState, Steps, StepsState,
};

use super::ExcitationSettings;
use super::kind::MAX_ENTRIES;

/// Any of the core's references, chosen at run time.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "each variant is the core's type of that name")]
#[expect(clippy::large_enum_variant, reason = "there is one to an experiment")]
pub enum Reference<N> {
    BandLimitedWhiteNoise(BandLimitedWhiteNoise),
    Prbs(Prbs<N>),
    Multisine(Multisine<N, MAX_ENTRIES>),
    Chirp(Chirp<N>),
    Square(Square<N>),
    Steps(Steps<N, MAX_ENTRIES>),
    None,
}

/// Progress of a [`Reference`].
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "each variant is the core's type of that name")]
pub enum ReferenceState<N> {
    BandLimitedWhiteNoise(BandLimitedWhiteNoiseState<N>),
    Prbs(PrbsState),
    Multisine(MultisineState<MAX_ENTRIES>),
    Chirp(ChirpState),
    Square(SquareState<N>),
    Steps(StepsState),
    None,
}

impl<N: Number> Reference<N> {
    /// The reference of these settings.
    ///
    /// # Errors
    /// The parameter out of its range, by its key.
    pub fn new(units: &Units, settings: &ExcitationSettings) -> Result<Self, OutOfRange> {
        Ok(match *settings {
            ExcitationSettings::BandLimitedWhiteNoise {
                power,
                sample_time,
                seed,
            } => Self::BandLimitedWhiteNoise(BandLimitedWhiteNoise::new(
                units,
                power,
                sample_time,
                seed,
            )?),
            ExcitationSettings::Prbs {
                amplitude,
                hold,
                order,
            } => Self::Prbs(Prbs::new(units, amplitude, hold, order)?),
            ExcitationSettings::Multisine(ref tones) => {
                Self::Multisine(Multisine::new(units, tones)?)
            }
            ExcitationSettings::Chirp {
                amplitude,
                from,
                to,
                duration,
            } => Self::Chirp(Chirp::new(units, amplitude, from, to, duration)?),
            ExcitationSettings::Square { amplitude, period } => {
                Self::Square(Square::new(units, amplitude, period)?)
            }
            ExcitationSettings::Steps { ref levels, hold } => {
                Self::Steps(Steps::new(units, levels, hold)?)
            }
            ExcitationSettings::None => Self::None,
        })
    }
}

impl<N: Number> Excitation<N> for Reference<N> {
    type State = ReferenceState<N>;

    fn start(&self) -> ReferenceState<N> {
        match self {
            Self::BandLimitedWhiteNoise(noise) => {
                ReferenceState::BandLimitedWhiteNoise(noise.start())
            }
            Self::Prbs(prbs) => ReferenceState::Prbs(prbs.start()),
            Self::Multisine(sine) => ReferenceState::Multisine(sine.start()),
            Self::Chirp(chirp) => ReferenceState::Chirp(chirp.start()),
            Self::Square(square) => ReferenceState::Square(square.start()),
            Self::Steps(steps) => ReferenceState::Steps(Excitation::<N>::start(steps)),
            Self::None => ReferenceState::None,
        }
    }

    #[inline]
    fn process(&self, state: &mut ReferenceState<N>) -> N {
        use ReferenceState as State;
        match (self, state) {
            (Self::BandLimitedWhiteNoise(noise), State::BandLimitedWhiteNoise(state)) => {
                noise.process(state)
            }
            (Self::Prbs(prbs), State::Prbs(state)) => prbs.process(state),
            (Self::Multisine(sine), State::Multisine(state)) => sine.process(state),
            (Self::Chirp(chirp), State::Chirp(state)) => chirp.process(state),
            (Self::Square(square), State::Square(state)) => square.process(state),
            (Self::Steps(steps), State::Steps(state)) => steps.process(state),
            // A state of another kind cannot arise from `start`; standing still is then harmless.
            _ => N::ZERO,
        }
    }
}
