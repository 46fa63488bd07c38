//! The end of a run as it was recorded.

use std::collections::VecDeque;

use crate::experiment::Sample;

/// The kept part of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kept {
    /// Rad.
    pub(super) position: f64,
    /// The command that acted from there on.
    pub(super) command: f64,
    /// A motion begins here: the samples before are of another.
    pub(super) begins: bool,
}

/// The last samples of a run: position and the command that acted from there on. A shorter run is
/// kept whole; of a longer one its end is judged, where the estimates are at their best.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    samples: VecDeque<Kept>,
    most: usize,
}

impl Stretch {
    /// Keeps a number of samples at most.
    pub(super) fn new(most: usize) -> Self {
        Self {
            samples: VecDeque::new(),
            most,
        }
    }

    /// Takes in a sample.
    #[inline]
    pub(super) fn add(&mut self, sample: &Sample) {
        if self.samples.len() == self.most {
            self.samples.pop_front();
        }
        self.samples.push_back(Kept {
            position: sample.position,
            command: sample.command,
            begins: sample.begins,
        });
    }

    /// Forgets everything: the record continues elsewhere.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
    }

    /// The kept samples, in order.
    pub(super) fn samples(&self) -> impl ExactSizeIterator<Item = Kept> + Clone + '_ {
        self.samples.iter().copied()
    }
}
