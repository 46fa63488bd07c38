use super::block::Block;
use crate::number::Number;

/// Successive blocks of a motion, from the first.
pub trait Blocks<N> {
    /// The block of an index; none behind the last.
    fn block(&self, index: usize) -> Option<&Block<N>>;
}

/// The last blocks of samples, at most W: 12 W bytes in `f32`.
///
/// A fit reads the blocks that were there when it began. Meanwhile blocks are only appended, and a
/// full record takes no more. It then begins anew with the first block after the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Record<N, const W: usize> {
    blocks: [Block<N>; W],
    first: usize,
    count: usize,
    reading: bool,
    missed: bool,
}

impl<N: Number, const W: usize> Record<N, W> {
    /// No block yet.
    pub(crate) fn empty() -> Self {
        Self {
            blocks: [Block {
                travel: N::ZERO,
                command: N::ZERO,
                first_moment: N::ZERO,
            }; W],
            first: 0,
            count: 0,
            reading: false,
            missed: false,
        }
    }

    /// Blocks in the record.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// True if the record is full, and the next block replaces the oldest.
    pub(crate) fn is_full(&self) -> bool {
        self.count == W
    }

    /// Empties the record.
    pub(crate) fn clear(&mut self) {
        self.first = 0;
        self.count = 0;
        self.reading = false;
        self.missed = false;
    }

    /// Takes a block.
    pub(crate) fn push(&mut self, block: &Block<N>) {
        if self.missed && !self.reading {
            self.clear();
        }
        if self.is_full() {
            if self.reading {
                self.missed = true;
                return;
            }
            self.first = if self.first + 1 >= W {
                0
            } else {
                self.first + 1
            };
            self.count -= 1;
        }
        let place = self.slot(self.count);
        if let Some(slot) = self.blocks.get_mut(place) {
            *slot = *block;
            self.count += 1;
        }
    }

    fn slot(&self, index: usize) -> usize {
        let place = self.first + index;
        if place >= W { place - W } else { place }
    }

    /// Keeps the blocks where they are until [`Record::release`].
    pub(crate) fn hold(&mut self) {
        self.reading = true;
    }

    pub(crate) fn release(&mut self) {
        self.reading = false;
    }
}

impl<N: Number, const W: usize> Blocks<N> for Record<N, W> {
    fn block(&self, index: usize) -> Option<&Block<N>> {
        self.blocks
            .get(self.slot(index))
            .filter(|_| index < self.count)
    }
}
