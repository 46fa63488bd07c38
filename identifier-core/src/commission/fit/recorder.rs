use super::FitSettings;
use crate::identifier::{Blocking, NumberedBlock, Recorder};
use crate::number::Number;

/// Condenses a motion to blocks: the interrupt's share of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionRecorder<N> {
    blocking: Blocking<N>,
    recorder: Recorder<N>,
}

impl<N: Number> MotionRecorder<N> {
    /// For fits with these settings.
    #[must_use]
    pub fn new(settings: &FitSettings) -> Self {
        Self {
            blocking: Blocking::of(settings.block()),
            recorder: Recorder::EMPTY,
        }
    }

    /// Begins anew with the next sample, which is then the first of a motion.
    pub fn begin_anew(&mut self) {
        self.recorder.begin_anew();
    }

    /// Takes a sample: the counts moved since the last, and the command from this sample on. Returns a
    /// block as soon as it is full.
    #[inline]
    pub fn push(&mut self, increment: N, command: N) -> Option<NumberedBlock<N>> {
        self.recorder.push(&self.blocking, increment, command);
        self.recorder.take()
    }
}
