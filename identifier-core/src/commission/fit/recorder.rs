use super::FitSettings;
use crate::fit::{Blocking, NumberedBlock, Recorder};
use crate::number::Number;

/// Condenses a motion to blocks that also end where the command changes by much, so that within them it is nearly constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MotionRecorder<N> {
    longest: Blocking<N>,
    /// A change of the command that ends a block.
    much: N,
    /// The command with which the open block began.
    began: N,
    recorder: Recorder<N>,
}

impl<N: Number> MotionRecorder<N> {
    /// The longest block, s.
    const MAX_BLOCK_TIME: f64 = 8e-4;

    /// Of the largest command: a change that ends a block.
    const MAX_COMMAND_CHANGE: f64 = 0.02;

    /// For fits with these settings.
    #[must_use]
    pub(crate) fn new(settings: &FitSettings) -> Self {
        Self {
            // Casts saturate.
            longest: Blocking::new((Self::MAX_BLOCK_TIME / settings.sample_time) as u32),
            much: N::from_f64(Self::MAX_COMMAND_CHANGE * settings.max_command),
            began: N::ZERO,
            recorder: Recorder::EMPTY,
        }
    }

    /// Begins anew with the next sample, which is then the first of a motion: a number is left out.
    pub(crate) fn begin_anew(&mut self) {
        self.recorder.begin_anew();
    }

    /// Takes a sample: the counts moved since the last, and the command from this sample on.
    #[inline]
    pub(crate) fn push(&mut self, increment: N, command: N) {
        if let Some(first) = self.recorder.first_command() {
            self.began = first;
        }
        self.recorder.push(&self.longest, increment, command);
        if (command - self.began).magnitude() > self.much {
            self.recorder.end_block();
        }
    }

    /// The block that has ended with the last sample.
    #[inline]
    pub(crate) fn take(&mut self) -> Option<NumberedBlock<N>> {
        self.recorder.take()
    }
}
