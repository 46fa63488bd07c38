//! Sums over a few samples, which blocks of several lengths are made of.

use super::blocks::larger;
use crate::number::Number;

/// Parts of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parts {
    /// Samples.
    length: i32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PartsState<N> {
    samples: i32,
    /// Samples running without a count.
    quiet: i32,
    part: Part<N>,
}

/// What has been seen in a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Part<N> {
    pub(super) counts: N,
    /// The sum of the commands, and the sum of its partial sums.
    pub(super) sum: N,
    pub(super) double_sum: N,
    /// The largest command to either side.
    pub(super) largest: N,
    /// Whether the servo has turned in it.
    pub(super) turned: bool,
    /// The most samples running without a count, those of the part before included.
    pub(super) longest: i32,
}

impl<N: Number> Part<N> {
    const EMPTY: Self = Self {
        counts: N::ZERO,
        sum: N::ZERO,
        double_sum: N::ZERO,
        largest: N::ZERO,
        turned: false,
        longest: 0,
    };
}

impl<N: Number> PartsState<N> {
    /// Nothing has been seen yet.
    pub(super) const START: Self = Self {
        samples: 0,
        quiet: 0,
        part: Part::EMPTY,
    };
}

impl Parts {
    pub(super) fn new(length: i32) -> Self {
        Self { length }
    }

    /// A sample; at the end of a part, what has been seen in it.
    #[inline]
    pub(super) fn process<N: Number>(
        &self,
        state: &mut PartsState<N>,
        increment: N,
        command: N,
    ) -> Option<Part<N>> {
        let part = &mut state.part;
        part.largest = larger(part.largest, command.magnitude());
        if increment == N::ZERO {
            state.quiet = state.quiet.saturating_add(1);
            part.longest = part.longest.max(state.quiet);
        } else {
            state.quiet = 0;
            part.turned |= increment * part.counts < N::ZERO;
            part.counts += increment;
        }
        part.double_sum += part.sum + N::from_f64(0.5) * command;
        part.sum += command;
        state.samples += 1;
        if state.samples < self.length {
            return None;
        }
        state.samples = 0;
        Some(core::mem::replace(&mut state.part, Part::EMPTY))
    }
}
