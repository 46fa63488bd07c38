//! What acts before and behind the PID.

use super::feed_forward::{FeedForward, ReferenceMotion};
use super::notch::{Notch, NotchState};
use super::reference_filter::{FilteredError, ReferenceFilter};
use crate::constants::encode;
use crate::number::{Arithmetic, Encoded};

/// What a controller does to the error before its PID and to the command behind it. It is a type, so that a loop
/// without it pays nothing for it.
pub trait Shaping<N: Arithmetic>: Copy + core::fmt::Debug + Default + PartialEq {
    /// The state between samples; by default at rest.
    type State: Copy + core::fmt::Debug + Default + PartialEq;

    /// The state that continues from an error and a command.
    fn continuing(error: N, command: N) -> Self::State;

    /// Takes the error of a sample, the increment since the last one and the PID's command of an error. Returns the
    /// shaped error and command, neither of them limited, and the state after it where that changes.
    fn process(
        &self,
        state: &Self::State,
        error: N,
        increment: N,
        wanted: impl Fn(N) -> N,
    ) -> (N, N, Option<Self::State>);
}

/// No shaping: the PID alone.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Unshaped;

encode! {
    [] Unshaped as "Unshaped" {}
}

impl<N: Arithmetic> Shaping<N> for Unshaped {
    type State = ();

    fn continuing(_: N, _: N) {}

    #[inline(always)]
    fn process(&self, (): &(), error: N, _: N, wanted: impl Fn(N) -> N) -> (N, N, Option<()>) {
        (error, wanted(error), None)
    }
}

/// A filter of the reference, a feed-forward and a notch filter of the command, each of which may be none. Fixed point
/// has the filter alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaped<N: Arithmetic> {
    reference: ReferenceFilter<N>,
    feed_forward: FeedForward<N>,
    notch: Notch<N>,
    /// One of these three is there.
    is_there: bool,
    /// From an increment to an error.
    to_error: N::Shift,
}

encode! {
    [N: Encoded] Shaped<N> as "Shaped" { reference, feed_forward, notch, is_there, to_error }
}

/// The state of [`Shaped`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapedState<N> {
    reference: FilteredError<N>,
    motion: ReferenceMotion<N>,
    notch: NotchState<N>,
}

impl<N: Arithmetic> Default for ShapedState<N> {
    fn default() -> Self {
        Shaped::<N>::continuing(N::ZERO, N::ZERO)
    }
}

impl<N: Arithmetic> Default for Shaped<N> {
    /// With none of them.
    fn default() -> Self {
        Self::new(ReferenceFilter::NONE, FeedForward::default(), Notch::NONE)
    }
}

impl<N: Arithmetic> Shaped<N> {
    /// With these, where increments have the full scale of errors.
    #[inline]
    #[must_use]
    pub fn new(
        reference: ReferenceFilter<N>,
        feed_forward: FeedForward<N>,
        notch: Notch<N>,
    ) -> Self {
        Self {
            reference,
            feed_forward,
            notch,
            is_there: reference.is_there() || feed_forward.is_there() || notch.is_there(),
            to_error: N::lower(0),
        }
    }

    /// The same where increments have a full scale that is finer by a number of bits.
    pub(super) fn with_finer_increments(self, finer: i32) -> Self {
        let to_error = N::lower(finer);
        Self { to_error, ..self }
    }

    /// A function of its own, for a sample without any of them not to pay for its registers.
    #[inline(never)]
    fn shape(
        &self,
        state: &ShapedState<N>,
        error: N,
        increment: N,
        wanted: impl Fn(N) -> N,
    ) -> (N, N, ShapedState<N>) {
        let mut next = *state;
        let moved = increment.lowered(self.to_error);
        let error = self.reference.process(&mut next.reference, error, moved);
        if N::IS_FIXED {
            return (error, wanted(error), next);
        }
        let (error, feed_forward) = self
            .feed_forward
            .process(&mut next.motion, error, increment);
        let command = wanted(error) + feed_forward;
        (error, self.notch.process(&mut next.notch, command), next)
    }
}

impl<N: Arithmetic> Shaping<N> for Shaped<N> {
    type State = ShapedState<N>;

    fn continuing(error: N, command: N) -> ShapedState<N> {
        ShapedState {
            reference: FilteredError(error),
            motion: FeedForward::at_rest(error),
            notch: NotchState::at(command),
        }
    }

    #[inline(always)]
    fn process(
        &self,
        state: &ShapedState<N>,
        error: N,
        increment: N,
        wanted: impl Fn(N) -> N,
    ) -> (N, N, Option<ShapedState<N>>) {
        if self.is_there {
            let (error, command, next) = self.shape(state, error, increment, wanted);
            (error, command, Some(next))
        } else {
            (error, wanted(error), None)
        }
    }
}
