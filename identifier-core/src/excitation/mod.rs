//! Reference signals that keep the regressor persistently exciting.
//!
//! Every generator is configured in SI (rad, s, rad/s), gives positions in the machine units of
//! the [`Units`](crate::units::Units) it was built with, one per control sample, and is the same
//! sequence on every machine: phases and shift registers are integers, and no platform libm is
//! called.

mod chirp;
mod multisine;
mod oscillator;
mod prbs;
mod square;
mod steps;
mod white_noise;

pub use chirp::{Chirp, ChirpState};
pub use multisine::{Multisine, MultisineState, Tone};
pub use prbs::{Prbs, PrbsState};
pub use square::{Square, SquareState};
pub use steps::{Steps, StepsState};
pub use white_noise::{BandLimitedWhiteNoise, BandLimitedWhiteNoiseState, NormalSource};

use crate::error::{Allowed, OutOfRange};
use crate::number::Number;

/// A reference generator: configuration here, progress in the state.
pub trait Excitation<N: Number> {
    /// What the generator remembers between samples.
    type State: Copy + core::fmt::Debug;

    /// The state before the first sample.
    fn start(&self) -> Self::State;

    /// The reference of this sample, machine units of position.
    fn process(&self, state: &mut Self::State) -> N;
}

/// A hold time (s) in steps of so many seconds.
///
/// # Errors
/// The time must be a whole, positive number of steps.
fn whole_steps(parameter: &'static str, time: f64, step: f64) -> Result<u32, OutOfRange> {
    let longest = f64::from(u32::MAX) * step;
    Allowed::MultipleOf(step).check(parameter, time)?;
    Allowed::AtMost(longest).check(parameter, time)?;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive and at most u32::MAX by the checks above"
    )]
    Ok(libm::round(time / step) as u32)
}

/// Counts control samples within one hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Hold {
    left: u32,
}

impl Hold {
    const EXPIRED: Self = Self { left: 0 };

    /// True once every `samples` samples, first at the first.
    #[inline]
    fn expires(&mut self, samples: u32) -> bool {
        if self.left == 0 {
            self.left = samples - 1;
            true
        } else {
            self.left -= 1;
            false
        }
    }
}
