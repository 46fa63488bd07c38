//! The reference signal, chosen at run time.

use identifier_core::error::OutOfRange;
use identifier_core::excitation::{Excitation, Prbs};
use identifier_core::number::Number;
use identifier_core::units::Units;
use virtual_servo::excitation::{BandLimitedWhiteNoise, Chirp, Multisine, SineTone, Square, Steps};

use identifier_log::named;
use identifier_log::scenario::MAX_ENTRIES;

named! {
    /// The kinds of reference.
    #[derive(Default)]
    pub enum ExcitationKind {
        /// Band-limited white noise.
        BandLimitedWhiteNoise = "band-limited-white-noise" takes &["power", "sample_time", "seed"],
        /// Pseudo-random binary sequence.
        Prbs = "prbs" takes &["amplitude", "hold", "order"],
        /// Sum of sines.
        Multisine = "multisine" takes &["amplitudes", "frequencies"],
        /// Sine whose frequency rises or falls.
        Chirp = "chirp" takes &["amplitude", "from", "to", "duration"],
        /// Square wave.
        Square = "square" takes &["amplitude", "period"],
        /// Staircase.
        Steps = "steps" takes &["levels", "hold"],
        /// Zero.
        #[default]
        None = "none",
    }
}

/// The settings of the reference, SI; each kind takes its own part. By default it is zero.
#[derive(Debug, Clone, PartialEq, Default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, documented there"
)]
pub struct ExcitationSettings {
    pub kind: ExcitationKind,
    pub power: f64,
    pub sample_time: f64,
    pub seed: u32,
    pub amplitude: f64,
    pub hold: f64,
    pub order: u32,
    pub amplitudes: Vec<f64>,
    pub frequencies: Vec<f64>,
    pub from: f64,
    pub to: f64,
    pub duration: f64,
    pub period: f64,
    pub levels: Vec<f64>,
}

impl ExcitationSettings {
    /// The paper's reference, which is the default.
    pub(super) fn paper() -> Self {
        Self {
            kind: ExcitationKind::BandLimitedWhiteNoise,
            power: 0.005,
            sample_time: 0.1,
            seed: 1_212_121,
            ..Self::default()
        }
    }

    /// The seed of a reference that has one.
    #[must_use]
    pub fn seed(&self) -> Option<u32> {
        (self.kind == ExcitationKind::BandLimitedWhiteNoise).then_some(self.seed)
    }
}

/// The references of the core as one type, and their states as another.
macro_rules! references {
    ($($kind:ident: $type:ty),*) => {
        /// Any of the core's references, chosen at run time.
        #[derive(Debug, Clone, Copy)]
        #[expect(missing_docs, reason = "each variant is the core's type of that name")]
        #[expect(clippy::large_enum_variant, reason = "there is one to an experiment")]
        pub enum Reference<N: Number> {
            $($kind($type),)*
            None,
        }

        /// Progress of a [`Reference`].
        #[derive(Debug, Clone, Copy)]
        #[expect(missing_docs, reason = "each variant is the state of the core's type of that name")]
        pub enum ReferenceState<N: Number> {
            $($kind(<$type as Excitation<N>>::State),)*
            None,
        }

        impl<N: Number> Excitation<N> for Reference<N> {
            type State = ReferenceState<N>;

            fn start(&self) -> ReferenceState<N> {
                match self {
                    $(Self::$kind(reference) => {
                        ReferenceState::$kind(Excitation::<N>::start(reference))
                    })*
                    Self::None => ReferenceState::None,
                }
            }

            #[inline]
            fn process(&self, state: &mut ReferenceState<N>) -> N {
                match (self, state) {
                    $((Self::$kind(reference), ReferenceState::$kind(state)) => {
                        reference.process(state)
                    })*
                    // A state of another kind cannot arise from `start`; standing still is then harmless.
                    _ => N::ZERO,
                }
            }
        }
    };
}

references! {
    BandLimitedWhiteNoise: BandLimitedWhiteNoise,
    Prbs: Prbs<N>,
    Multisine: Multisine<N, MAX_ENTRIES>,
    Chirp: Chirp<N>,
    Square: Square<N>,
    Steps: Steps<N, MAX_ENTRIES>
}

impl<N: Number> Reference<N> {
    /// The reference of these settings.
    ///
    /// # Errors
    /// The parameter out of its range, by its key.
    pub fn new(units: &Units, settings: &ExcitationSettings) -> Result<Self, OutOfRange> {
        let s = settings;
        Ok(match s.kind {
            ExcitationKind::BandLimitedWhiteNoise => Self::BandLimitedWhiteNoise(
                BandLimitedWhiteNoise::new(units, s.power, s.sample_time, s.seed)?,
            ),
            ExcitationKind::Prbs => Self::Prbs(Prbs::new(units, s.amplitude, s.hold, s.order)?),
            ExcitationKind::Multisine => {
                let tones = s.amplitudes.iter().zip(&s.frequencies);
                let tones: Vec<_> = tones
                    .map(|(&amplitude, &frequency)| SineTone {
                        amplitude,
                        frequency,
                    })
                    .collect();
                Self::Multisine(Multisine::new(units, &tones)?)
            }
            ExcitationKind::Chirp => {
                Self::Chirp(Chirp::new(units, s.amplitude, s.from, s.to, s.duration)?)
            }
            ExcitationKind::Square => Self::Square(Square::new(units, s.amplitude, s.period)?),
            ExcitationKind::Steps => Self::Steps(Steps::new(units, &s.levels, s.hold)?),
            ExcitationKind::None => Self::None,
        })
    }
}
