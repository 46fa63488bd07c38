use crate::number::Number;

/// What a record keeps of a few successive samples: enough to move a model over all of them at
/// once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block<N> {
    /// How far the servo moved, counts.
    pub travel: N,
    /// Mean command, command units.
    pub command: N,
    /// How much further a unit of gain goes within the block because the command came earlier than
    /// evenly spread: ∑ⱼ (m − j − ½) uⱼ/m² − ū/2 for m samples, command units.
    pub lead: N,
}

/// The last blocks of samples, at most W, in storage that the caller owns: 12 W bytes in `f32`.
///
/// The recorder (an interrupt) only appends, the fitter (the background) only reads what had been
/// appended when its fit began. While a fit reads, a full record takes nothing more; it begins anew
/// after a fit that found nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record<N, const W: usize> {
    blocks: [Block<N>; W],
    first: usize,
    count: usize,
    open: Open<N>,
    reading: bool,
    missed: bool,
}

/// The block that is being gathered.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Open<N> {
    travel: N,
    sum: N,
    weighted: N,
    samples: u32,
    /// The command that acts now; its effect comes with the next increment.
    acting: Option<N>,
}

impl<N: Number> Open<N> {
    const EMPTY: Self = Self {
        travel: N::ZERO,
        sum: N::ZERO,
        weighted: N::ZERO,
        samples: 0,
        acting: None,
    };
}

/// How many samples make a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocking<N> {
    samples: u32,
    per_sample: N,
}

impl<N: Number> Blocking<N> {
    /// Blocks of `samples`, at least one.
    #[must_use]
    pub fn of(samples: u32) -> Self {
        let samples = samples.max(1);
        Self {
            samples,
            per_sample: N::from_f64(1.0 / f64::from(samples)),
        }
    }

    /// The samples of a block.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.samples
    }
}

impl<N: Number, const W: usize> Record<N, W> {
    /// No sample yet.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            blocks: [Block {
                travel: N::ZERO,
                command: N::ZERO,
                lead: N::ZERO,
            }; W],
            first: 0,
            count: 0,
            open: Open::EMPTY,
            reading: false,
            missed: false,
        }
    }

    /// Blocks in the record.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether there is no room left, and the next block takes the place of the oldest.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.count == W
    }

    /// Forgets everything, also the command that acts.
    pub fn clear(&mut self) {
        self.first = 0;
        self.count = 0;
        self.open = Open::EMPTY;
        self.missed = false;
    }

    /// Velocity over the last block, counts per sample.
    #[must_use]
    pub(crate) fn velocity(&self, blocking: &Blocking<N>) -> N {
        let last = self.count.checked_sub(1).and_then(|last| self.get(last));
        last.map_or(N::ZERO, |block| block.travel * blocking.per_sample)
    }

    /// Takes in a sample; true when it completed a block.
    #[inline]
    pub fn push(&mut self, blocking: &Blocking<N>, increment: N, command: N) -> bool {
        let Some(acted) = self.open.acting.replace(command) else {
            return false;
        };
        let open = &mut self.open;
        open.travel += increment;
        // ∑ⱼ (m − j − ½) uⱼ is the sum of the running sums, less half the last.
        open.sum += acted;
        open.weighted += open.sum;
        open.samples += 1;
        if open.samples < blocking.samples {
            return false;
        }
        self.close(blocking);
        true
    }

    fn close(&mut self, blocking: &Blocking<N>) {
        let half = N::from_f64(0.5);
        let per_sample = blocking.per_sample;
        let command = self.open.sum * per_sample;
        let moment = (self.open.weighted - half * self.open.sum) * per_sample * per_sample;
        let block = Block {
            travel: self.open.travel,
            command,
            lead: moment - half * command,
        };
        self.open = Open {
            acting: self.open.acting,
            ..Open::EMPTY
        };
        if self.missed && !self.reading {
            self.first = 0;
            self.count = 0;
            self.missed = false;
        }
        if self.count == W {
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
        let place = self.place(self.count);
        if let Some(slot) = self.blocks.get_mut(place) {
            *slot = block;
            self.count += 1;
        }
    }

    fn place(&self, index: usize) -> usize {
        let place = self.first + index;
        if place >= W { place - W } else { place }
    }

    pub(super) fn get(&self, index: usize) -> Option<&Block<N>> {
        self.blocks
            .get(self.place(index))
            .filter(|_| index < self.count)
    }

    /// Keeps the blocks where they are until [`Record::release`].
    pub(crate) fn hold(&mut self) {
        self.reading = true;
    }

    pub(crate) fn release(&mut self) {
        self.reading = false;
    }
}
