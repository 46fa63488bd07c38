use super::super::noise::EDGE_COUNTS;
use super::piece::Piece;
use identifier_core::fit::{Block, Blocks};
use identifier_core::identifier::NumberedBlock;
use identifier_core::number::Number;

/// The record of a motion, of at most W blocks of the same number of samples. If it is full, every two blocks become
/// one. A short motion is thus kept finely and a long one as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MotionRecord<N, const W: usize> {
    blocks: [Block<N>; W],
    count: usize,
    /// Of each.
    samples: N,
    /// The beginning of the next block.
    open: Piece<N>,
    next: Option<u32>,
    has_gap: bool,
}

impl<N: Number, const W: usize> MotionRecord<N, W> {
    /// Nothing recorded yet: all of it zero, as static memory is.
    pub(crate) const EMPTY: Self = Self {
        blocks: [Piece::NONE.block; W],
        count: 0,
        samples: N::ZERO,
        open: Piece::NONE,
        next: None,
        has_gap: false,
    };

    /// Begins anew where it is: it is too large for a stack.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
        (self.open, self.next, self.has_gap) = (Piece::NONE, None, false);
    }

    /// Takes a block. False, and nothing is taken, if one is missing before it.
    pub(crate) fn take(&mut self, block: &NumberedBlock<N>) -> bool {
        let missing = self.next.is_some_and(|next| next != block.number);
        if missing || self.has_gap {
            self.has_gap = true;
            return false;
        }
        if self.next.is_none() {
            self.samples = block.samples;
        }
        self.next = Some(block.number.wrapping_add(1));
        self.open = self.open.followed_by(&Piece::from_block(block));
        if self.open.samples < self.samples {
            return true;
        }
        match self.blocks.get_mut(self.count) {
            Some(place) => {
                *place = self.open.block;
                self.count += 1;
                self.open = Piece::NONE;
            }
            None => self.join(),
        }
        true
    }

    /// Every two blocks become one.
    fn join(&mut self) {
        let whole = |block: &Block<N>| Piece {
            samples: N::ONE,
            block: *block,
        };
        self.count = W / 2;
        for index in 0..self.count {
            let joined = match self.blocks.get(2 * index..2 * index + 2) {
                Some([one, next]) => whole(one).followed_by(&whole(next)).block,
                _ => continue,
            };
            if let Some(place) = self.blocks.get_mut(index) {
                *place = joined;
            }
        }
        self.samples = self.samples + self.samples;
    }

    /// True if no block was missing.
    #[must_use]
    pub(crate) fn is_complete(&self) -> bool {
        !self.has_gap
    }

    /// Blocks in the record.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Samples of each, at least one.
    pub(crate) fn samples(&self) -> N {
        self.samples.larger(N::ONE)
    }

    /// The blocks, from the first.
    pub(crate) fn blocks(&self) -> &[Block<N>] {
        self.blocks.get(..self.count).unwrap_or_default()
    }

    /// From the lowest to the highest position, counts.
    pub(crate) fn range(&self) -> N {
        let (mut position, mut low, mut high) = (N::ZERO, N::ZERO, N::ZERO);
        for block in self.blocks() {
            position += block.travel;
            low = low.smaller(position);
            high = high.larger(position);
        }
        high - low
    }

    /// The largest mean speed over a block, counts per sample.
    pub(crate) fn fastest(&self) -> N {
        let farthest = self
            .blocks()
            .iter()
            .fold(N::ZERO, |most, block| most.larger(block.travel.magnitude()));
        farthest * self.samples().reciprocal()
    }

    /// The mean speed over at least this many first samples; zero where it is within rounding.
    pub(crate) fn speed_at_first(&self, samples: N) -> N {
        let (mut time, mut travel) = (N::ZERO, N::ZERO);
        for block in self.blocks() {
            time += self.samples;
            travel += block.travel;
            if time >= samples {
                break;
            }
        }
        if travel.magnitude() > N::from_f64(EDGE_COUNTS) {
            travel.magnitude() * time.reciprocal()
        } else {
            N::ZERO
        }
    }
}

impl<N: Number, const W: usize> Blocks<N> for MotionRecord<N, W> {
    fn block(&self, index: usize) -> Option<&Block<N>> {
        self.blocks.get(index).filter(|_| index < self.count)
    }
}
