use crate::number::Number;

/// The last samples of a loop, at most W, in storage that the caller owns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window<N, const W: usize> {
    samples: [Recorded<N>; W],
    length: usize,
    first: usize,
    count: usize,
}

/// What a window keeps of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorded<N> {
    /// Reference.
    pub reference: N,
    /// Measured position.
    pub position: N,
    /// Known signal behind the controller and its limit.
    pub injection: N,
}

impl<N: Number, const W: usize> Window<N, W> {
    /// No sample yet, room for all W.
    #[must_use]
    pub fn empty() -> Self {
        Self::of_length(W)
    }

    /// No sample yet, room for `length` samples, at least one and at most W: a length that is known
    /// only when the program runs.
    #[must_use]
    pub fn of_length(length: usize) -> Self {
        Self {
            length: length.clamp(1, W),
            samples: [Recorded {
                reference: N::ZERO,
                position: N::ZERO,
                injection: N::ZERO,
            }; W],
            first: 0,
            count: 0,
        }
    }

    /// Samples in the window.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether there is no room left.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.count == self.length
    }

    /// Forgets its samples.
    pub fn clear(&mut self) {
        self.first = 0;
        self.count = 0;
    }

    /// Moves the origin by `moved`.
    pub(super) fn shift_origin(&mut self, moved: N) {
        for sample in &mut self.samples {
            sample.reference = sample.reference - moved;
            sample.position = sample.position - moved;
        }
    }

    pub(super) fn get(&self, index: usize) -> Option<&Recorded<N>> {
        let place = self.first + index;
        let wrapped = if place >= self.length {
            place - self.length
        } else {
            place
        };
        self.samples.get(wrapped).filter(|_| index < self.count)
    }

    pub(super) fn push(&mut self, sample: Recorded<N>) {
        let place = self.first + self.count;
        let wrapped = if place >= self.length {
            place - self.length
        } else {
            place
        };
        if let Some(slot) = self.samples.get_mut(wrapped) {
            *slot = sample;
            self.count += 1;
        }
    }

    pub(super) fn drop_first(&mut self) {
        self.first = if self.first + 1 >= self.length {
            0
        } else {
            self.first + 1
        };
        self.count = self.count.saturating_sub(1);
    }
}
