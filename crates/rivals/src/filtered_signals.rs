use identifier_core::number::Number;

use crate::recursion::{Recursion, RecursionState};
use crate::{Filtered, StateVariableFilter};

/// State of a method that fits filtered signals to each other: the command that acts until the next sample,
/// motion and command behind their filters, and a recursion of P parameters.
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

    /// Filters a sample, whose command acts from now on, and returns the rates of motion and command before
    /// it; none for a sample that is not finite, which changes nothing.
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
