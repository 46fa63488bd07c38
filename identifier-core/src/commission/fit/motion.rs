use super::block::Piece;
use crate::fit::NumberedBlock;
use crate::number::Number;

/// Of the largest command: a difference that does not matter.
const ALIKE: f64 = 0.02;

/// The record of a motion, of at most W pieces. Where it is full, neighbouring pieces become one, first
/// those between which the command hardly changes, so that a short motion is kept finely and a long one
/// as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MotionRecord<N, const W: usize> {
    pieces: [Piece<N>; W],
    count: usize,
    /// Pieces between which the command changes by no more may be joined.
    joined: N,
    /// The longest that a piece may be, samples.
    longest: N,
    next: Option<u32>,
    complete: bool,
}

impl<N: Number, const W: usize> MotionRecord<N, W> {
    /// Nothing recorded yet.
    pub(crate) const EMPTY: Self = Self {
        pieces: [Piece::NONE; W],
        count: 0,
        joined: N::ZERO,
        longest: N::ONE,
        next: None,
        complete: true,
    };

    /// Takes a block. False, and nothing is taken, if one is missing before it.
    pub(crate) fn take(&mut self, block: &NumberedBlock<N>) -> bool {
        let missing = self.next.is_some_and(|next| next != block.number);
        if missing || !self.complete {
            self.complete = false;
            return false;
        }
        self.next = Some(block.number.wrapping_add(1));
        if self.count == 0 {
            (self.joined, self.longest) = (N::ZERO, N::ONE);
        }
        let piece = Piece::from_block(block);
        let alike = N::from_f64(ALIKE) * piece.command.magnitude();
        if alike > self.joined {
            self.joined = alike;
        }
        if piece.samples > self.longest {
            self.longest = piece.samples;
        }
        while self.count == W {
            self.join();
        }
        if let Some(place) = self.pieces.get_mut(self.count) {
            *place = piece;
            self.count += 1;
        }
        true
    }

    /// Neighbouring pieces become one; pieces may be longer, and their commands differ more, from then
    /// on.
    fn join(&mut self) {
        self.longest = self.longest + self.longest;
        self.joined = self.joined + self.joined;
        let mut kept = 0;
        let mut index = 0;
        while let Some(&first) = self.get(index) {
            let mut piece = first;
            index += 1;
            if let Some(next) = self.get(index) {
                let alike = (next.command - piece.command).magnitude() <= self.joined;
                if alike && piece.samples + next.samples <= self.longest {
                    piece = piece.followed_by(next);
                    index += 1;
                }
            }
            if let Some(place) = self.pieces.get_mut(kept) {
                *place = piece;
            }
            kept += 1;
        }
        self.count = kept;
    }

    /// True if no block was missing.
    #[must_use]
    pub(crate) fn is_complete(&self) -> bool {
        self.complete
    }

    /// Pieces in the record.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// The mean speed over at least this many first samples; zero where it is within rounding.
    pub(crate) fn speed_at_first(&self, samples: N) -> N {
        /// Counts that a servo at rest may show.
        const ROUNDING: f64 = 1.5;
        let (mut time, mut travel) = (N::ZERO, N::ZERO);
        for piece in self.pieces.iter().take(self.count) {
            time += piece.samples;
            travel += piece.travel;
            if time >= samples {
                break;
            }
        }
        if travel.magnitude() > N::from_f64(ROUNDING) {
            travel.magnitude() * time.reciprocal()
        } else {
            N::ZERO
        }
    }

    /// The pieces that span at least this many samples, or all.
    pub(crate) fn pieces_in(&self, samples: N) -> usize {
        let mut time = N::ZERO;
        for (piece, taken) in self.pieces.iter().zip(1..=self.count) {
            time += piece.samples;
            if time >= samples {
                return taken;
            }
        }
        self.count
    }

    /// The longest piece, samples; one of an empty record.
    pub(crate) fn longest(&self) -> N {
        let pieces = self.pieces.iter().take(self.count);
        pieces.fold(N::ONE, |longest, piece| {
            if piece.samples > longest {
                piece.samples
            } else {
                longest
            }
        })
    }

    pub(crate) fn get(&self, index: usize) -> Option<&Piece<N>> {
        self.pieces.get(index).filter(|_| index < self.count)
    }
}
