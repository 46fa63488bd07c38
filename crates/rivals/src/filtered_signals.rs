use identifier_core::number::Number;

use crate::recursion::{Recursion, RecursionState};
use crate::{Filtered, StateVariableFilter};

/// What a method remembers that fits filtered signals to each other: the command that acts until the next
/// sample, motion and command behind their filters, and a recursion of P parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredSignals<N: Number, const P: usize> {
    command: N,
    pub(super) motion: Filtered<N>,
    pub(super) drive: Filtered<N>,
    pub(super) recursion: RecursionState<N, P>,
}

impl<N: Number, const P: usize> FilteredSignals<N, P> {
    pub(super) fn at_rest(recursion: &Recursion<N, P>) -> Self {
        Self {
            command: N::ZERO,
            motion: Filtered::AT_REST,
            drive: Filtered::AT_REST,
            recursion: recursion.start(),
        }
    }

    /// Takes a sample into the filters; the command acts from now on. The rates of motion and command
    /// before it, or none if what came is not finite: then nothing has changed.
    #[inline]
    pub(super) fn take(
        &mut self,
        filter: &StateVariableFilter<N>,
        increment: N,
        command: N,
    ) -> Option<[N; 2]> {
        if !(increment.is_finite() && command.is_finite()) {
            return None;
        }
        let before = [self.motion.rate, self.drive.rate];
        filter.process(&mut self.motion, increment);
        filter.process(&mut self.drive, self.command);
        self.command = command;
        Some(before)
    }
}
