//! The end of a run as it was recorded.

use std::collections::VecDeque;

use crate::experiment::Sample;

/// The last samples of a run: position and the command that acted from there on. A shorter run is
/// kept whole; of a longer one its end is judged, where the estimates are at their best.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    samples: VecDeque<(f64, f64)>,
    most: usize,
}

impl Stretch {
    /// Keeps so many samples at most.
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
        self.samples.push_back((sample.position, sample.command));
    }

    /// Forgets everything: what was recorded goes on elsewhere.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
    }

    /// Positions, rad, and commands.
    pub(super) fn samples(&self) -> impl ExactSizeIterator<Item = (f64, f64)> + Clone + '_ {
        self.samples.iter().copied()
    }
}
