use super::FitSettings;
use super::block::{MotionBlock, Piece};
use crate::number::Number;

/// Condenses a motion to blocks: the interrupt's share of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MotionRecorder<N> {
    longest: N,
    /// A change of the command that ends a block.
    much: N,
    open: Piece<N>,
    /// The command with which the open block began, and the one that acts now; its effect comes with the
    /// next increment.
    began: N,
    acting: Option<N>,
    next: u32,
}

impl<N: Number> MotionRecorder<N> {
    /// The longest block, s.
    const MAX_BLOCK_TIME: f64 = 8e-4;

    /// Of the largest command: a change that ends a block.
    const MAX_COMMAND_CHANGE: f64 = 0.02;

    /// For fits with these settings.
    #[must_use]
    pub(crate) fn new(settings: &FitSettings) -> Self {
        let longest = libm::floor(Self::MAX_BLOCK_TIME / settings.sample_time).max(1.0);
        Self {
            longest: N::from_f64(longest),
            much: N::from_f64(Self::MAX_COMMAND_CHANGE * settings.max_command),
            open: Piece::NONE,
            began: N::ZERO,
            acting: None,
            next: 0,
        }
    }

    /// Begins anew with the next sample, which is then the first of a motion: a number is left out.
    pub(crate) fn begin_anew(&mut self) {
        self.open = Piece::NONE;
        self.acting = None;
        self.next = self.next.wrapping_add(1);
    }

    /// Takes a sample: the counts moved since the last, and the command from this sample on. Returns a
    /// block that has ended.
    #[inline]
    pub(crate) fn push(&mut self, increment: N, command: N) -> Option<MotionBlock<N>> {
        let acted = self.acting.replace(command)?;
        if self.open.samples == N::ZERO {
            self.began = acted;
        }
        self.open = self.open.followed_by(&Piece::of_sample(increment, acted));
        let changes = (command - self.began).magnitude() > self.much;
        if !changes && self.open.samples < self.longest {
            return None;
        }
        let number = self.next;
        self.next = self.next.wrapping_add(1);
        let piece = core::mem::replace(&mut self.open, Piece::NONE);
        Some(MotionBlock { number, piece })
    }
}
