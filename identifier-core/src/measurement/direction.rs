//! The direction of a motion from counts.

use crate::number::Number;

/// The direction in which a servo moved over a piece of a record, zero at standstill. The travel over the piece
/// decides. If it is within the encoder's rounding, the pieces before and after it count too. `travel` is the travel
/// over each piece of the record, counts.
pub(crate) fn direction<N: Number>(index: usize, travel: impl Fn(usize) -> Option<N>) -> N {
    /// Travel that exceeds crossing one edge of the encoder to and fro.
    const BEYOND: f64 = 1.5;
    let beyond = N::from_f64(BEYOND);
    let at = |index: Option<usize>| index.and_then(&travel).unwrap_or(N::ZERO);
    let [before, own, after] = [index.checked_sub(1), Some(index), index.checked_add(1)].map(at);
    for way in [own, before + own + after] {
        if way > beyond {
            return N::ONE;
        }
        if way < -beyond {
            return -N::ONE;
        }
    }
    N::ZERO
}
