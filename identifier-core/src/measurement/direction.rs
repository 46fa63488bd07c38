//! The direction of a motion from counts.

use crate::number::Number;

/// The direction in which a servo moved, zero at standstill: by its own travel, or, if that is within the
/// encoder's rounding, by that before and after it too. All in counts.
pub(crate) fn direction<N: Number>([before, own, after]: [N; 3]) -> N {
    /// Travel that exceeds crossing one edge of the encoder to and fro.
    const BEYOND: f64 = 1.5;
    let beyond = N::from_f64(BEYOND);
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
