use crate::constants::{Encode, encode};
use crate::number::Number;

/// A few successive samples condensed to the inputs of one model step over all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block<N> {
    /// The servo's increment, counts.
    pub travel: N,
    /// Mean command, command units.
    pub command: N,
    /// The first moment: the additional distance per unit of gain within the block because the command came earlier
    /// than evenly spread. It is ∑ⱼ (m − j − ½) uⱼ/m² − ū/2 for m samples, command units.
    pub first_moment: N,
}

/// A few successive samples condensed: five words in `f32`. They pass from the interrupt that recorded them to the
/// background that fits to them.
///
/// Blocks between which nothing is missing have successive numbers. A lost block or a new beginning leaves a number
/// out. A fitter notices it by that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberedBlock<N> {
    /// Its number, wrapping at 32 bits.
    pub number: u32,
    /// Its samples.
    pub samples: N,
    /// The condensed samples.
    pub block: Block<N>,
}

/// The samples of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocking<N> {
    pub(super) samples: u32,
    pub(super) per_sample: N,
}

encode! {
    [N: Encode] Blocking<N> as "Blocking" { samples, per_sample }
}

impl<N: Number> Blocking<N> {
    /// Blocks of `samples`, at least one.
    #[must_use]
    pub fn new(samples: u32) -> Self {
        let samples = samples.max(1);
        Self {
            samples,
            per_sample: N::from_f64(1.0 / f64::from(samples)),
        }
    }
}
