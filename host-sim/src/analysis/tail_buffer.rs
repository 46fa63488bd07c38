//! The end of a run in its recorded form.

use std::collections::VecDeque;

use log_fit::Logged;

use identifier_log::experiment::Sample;

/// The last samples of a run: position and the command that acted from there on. A shorter run is kept whole. A longer
/// one is judged by its end, where the estimates are best.
#[derive(Debug, Clone, Default)]
pub(super) struct TailBuffer {
    samples: VecDeque<Logged>,
    most: usize,
}

impl TailBuffer {
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
        self.samples.push_back(sample.logged());
    }

    /// Forgets everything: the record continues elsewhere.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
    }

    /// The kept samples, in order.
    pub(super) fn samples(&mut self) -> &[Logged] {
        self.samples.make_contiguous()
    }
}
