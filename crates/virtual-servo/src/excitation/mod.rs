//! Reference signals for experiments, besides the drive's own
//! [`Prbs`](identifier_core::excitation::Prbs), and the random source of all noise.

mod chirp;
mod multisine;
mod oscillator;
mod square;
mod steps;
mod white_noise;

pub use chirp::{Chirp, ChirpState};
pub use multisine::{Multisine, MultisineState, Tone};
pub use square::{Square, SquareState};
pub use steps::{Steps, StepsState};
pub use white_noise::{BandLimitedWhiteNoise, BandLimitedWhiteNoiseState, NormalSource};
