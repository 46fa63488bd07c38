use crate::identifier::NumberedBlock;
use crate::number::Number;

/// The record of a motion, of at most W pieces. Where it is full, neighbouring pieces become one, so that
/// a short motion is kept finely and a long one as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<N, const W: usize> {
    pieces: [Piece<N>; W],
    count: usize,
    /// Blocks to a piece.
    blocks: u32,
    /// The piece that is being gathered, and its blocks.
    open: (Piece<N>, u32),
    next: Option<u32>,
    complete: bool,
}

/// Successive samples condensed to what moves a model over all of them at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece<N> {
    /// How far the servo moved, counts.
    pub(crate) travel: N,
    /// Mean command, command units.
    pub(crate) command: N,
    /// How much further a unit of gain goes within the piece because the command came earlier than
    /// evenly spread, command units.
    pub(crate) lead: N,
}

impl<N: Number> Piece<N> {
    pub(crate) const NONE: Self = Self {
        travel: N::ZERO,
        command: N::ZERO,
        lead: N::ZERO,
    };

    /// Two of `part` and 1 − `part` of the time of both.
    fn followed_by(&self, next: &Self, part: N) -> Self {
        let rest = N::ONE - part;
        let half = N::from_f64(0.5);
        Self {
            travel: self.travel + next.travel,
            command: part * self.command + rest * next.command,
            lead: part * part * self.lead
                + rest * rest * next.lead
                + half * part * rest * (self.command - next.command),
        }
    }
}

impl<N: Number, const W: usize> Motion<N, W> {
    /// Nothing recorded yet.
    pub const EMPTY: Self = Self {
        pieces: [Piece::NONE; W],
        count: 0,
        blocks: 1,
        open: (Piece::NONE, 0),
        next: None,
        complete: true,
    };

    /// Takes a block. False, and nothing is taken, if one is missing before it.
    pub fn take(&mut self, numbered: &NumberedBlock<N>) -> bool {
        let (number, [travel, command, lead]) = numbered.parts();
        let piece = Piece {
            travel,
            command,
            lead,
        };
        if self.next.is_some_and(|next| next != number) {
            self.complete = false;
            return false;
        }
        self.next = Some(number.wrapping_add(1));
        let (open, gathered) = self.open;
        let part = N::from_f64(f64::from(gathered) / f64::from(gathered + 1));
        self.open = (open.followed_by(&piece, part), gathered + 1);
        if self.open.1 >= self.blocks {
            self.close();
        }
        true
    }

    fn close(&mut self) {
        if self.count == W {
            self.halve();
            // The open piece is half of one of the new size.
            return;
        }
        if let Some(place) = self.pieces.get_mut(self.count) {
            *place = self.open.0;
            self.count += 1;
        }
        self.open = (Piece::NONE, 0);
    }

    /// Neighbouring pieces become one.
    fn halve(&mut self) {
        let half = N::from_f64(0.5);
        for index in 0..W / 2 {
            let (first, second) = (self.pieces[2 * index], self.pieces[2 * index + 1]);
            self.pieces[index] = first.followed_by(&second, half);
        }
        self.count = W / 2;
        self.blocks *= 2;
    }

    /// Whether no block was missing.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Pieces in the record.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Blocks to a piece.
    pub(crate) fn blocks_to_a_piece(&self) -> u32 {
        self.blocks
    }

    pub(crate) fn get(&self, index: usize) -> Option<&Piece<N>> {
        self.pieces.get(index).filter(|_| index < self.count)
    }
}
