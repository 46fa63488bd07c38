use super::motion::Piece;
use crate::number::Number;

/// The last pieces of a command that acts late.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Delayed<N> {
    last: [(N, N); PIECES],
    newest: usize,
}

const PIECES: usize = 16;

/// What acts over a piece, and how it changes with the delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Acting<N> {
    pub(super) command: N,
    pub(super) lead: N,
    pub(super) command_per_delay: N,
    pub(super) lead_per_delay: N,
}

impl<N: Number> Delayed<N> {
    /// The longest delay, pieces.
    pub(super) const LONGEST: f64 = (PIECES - 2) as f64;

    /// Before the record: the command with which it begins.
    pub(super) fn before(command: N) -> Self {
        Self {
            last: [(command, N::ZERO); PIECES],
            newest: 0,
        }
    }

    /// Takes a piece. With a part f of the delay the older of two pieces acts first:
    /// lead f (1 − f) (u₁ − u₀)/2.
    pub(super) fn take(&mut self, piece: &Piece<N>, delay: N) -> Acting<N> {
        self.newest = (self.newest + 1) % PIECES;
        self.last[self.newest] = (piece.command, piece.lead);
        let whole = delay.whole();
        let part = delay - N::from_count(whole);
        let whole = whole.unsigned_abs() as usize % (PIECES - 1);
        let early = self.last[(self.newest + PIECES - whole) % PIECES];
        let late = self.last[(self.newest + 2 * PIECES - whole - 1) % PIECES];
        let half = N::from_f64(0.5);
        let change = late.0 - early.0;
        Acting {
            command: early.0 + part * change,
            lead: early.1 + part * (late.1 - early.1) + half * part * (N::ONE - part) * change,
            command_per_delay: change,
            lead_per_delay: late.1 - early.1 + half * (N::ONE - part - part) * change,
        }
    }
}
