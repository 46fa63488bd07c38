//! Reference signals that keep the regressor persistently exciting: those that a drive makes itself.
//!
//! Every generator is configured in SI (rad, s, rad/s). It gives one position per control sample, in the machine units
//! of its [`Units`](crate::units::Units). The sequence is the same on every machine: phases and shift registers are
//! integers, and no platform libm is called.

mod hold;
mod prbs;

pub use hold::Hold;
pub use prbs::Prbs;

use crate::number::Number;

/// A reference generator: configuration here, progress in the state.
pub trait Excitation<N: Number> {
    /// The generator's memory between samples.
    type State: Copy + core::fmt::Debug;

    /// The state before the first sample.
    fn start(&self) -> Self::State;

    /// The reference of this sample, machine units of position.
    fn process(&self, state: &mut Self::State) -> N;
}
