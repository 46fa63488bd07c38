use core::marker::PhantomData;

use super::super::halves::RecordBlocks;
use super::super::identify::{Event, Identify, Update, check};
use crate::adaptation::IdentifiableSet;
use crate::error::StepError;
use crate::fit::{Blocking, NumberedBlock, Recorder};
use crate::model::ModelValues;
use crate::number::Number;
use crate::parameters::{AbCoulombLoad, PerParameter, ServoParameters, Terms, Unknown};
use crate::units::Units;

/// The interrupt's half of the windowed identifier: it records for a window of W blocks, and holds the
/// last result of the [`WindowFitter`](super::WindowFitter).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowRecorder<
    N,
    S,
    const P: usize,
    const W: usize = 256,
    F = AbCoulombLoad,
    const U: usize = 4,
> {
    pub(crate) blocking: Blocking<N>,
    pub(crate) units: Units,
    pub(crate) longest: N,
    pub(crate) initial: [f64; P],
    pub(crate) set: PhantomData<(S, F)>,
}

/// State of the interrupt's half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowRecorderState<N, const U: usize = 4> {
    recorder: Recorder<N>,
    explained: Option<WindowSolution<N, U>>,
    /// Of the last fit.
    at_bound: [bool; U],
    event: Event,
    fits: u32,
}

/// The result of a window fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowFitted<N, const U: usize = 4> {
    /// The number of the last block that it used.
    pub(super) last: u32,
    pub(super) at_bound: [bool; U],
    /// None where the motion could not be explained, or only at a bound.
    pub(super) explained: Option<WindowSolution<N, U>>,
}

/// The result of a fit that explains the motion, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WindowSolution<N, const U: usize> {
    /// The unknowns of the fit.
    pub(super) parameters: [N; U],
    pub(super) deviations: [N; U],
    pub(super) entered: Terms,
    /// Variance of the fit's errors, counts².
    pub(super) unexplained: N,
    /// Of the last block, counts.
    pub(super) output_error: N,
}

/// The estimates of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowEstimates<N, const P: usize> {
    values: [N; P],
    at_bounds: [bool; P],
}

impl<N, S, const P: usize, const W: usize, F, const U: usize> WindowRecorder<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    /// Fits that have ended with a result.
    #[must_use]
    pub fn fits(&self, state: &WindowRecorderState<N, U>) -> u32 {
        state.fits
    }

    /// The standard deviation of the last fit's errors, rad; at least a count's rounding. None before
    /// the first fit.
    #[must_use]
    pub fn unexplained(&self, state: &WindowRecorderState<N, U>) -> Option<f64> {
        let explained = state.explained.as_ref()?;
        Some(libm::sqrt(explained.unexplained.to_f64()) * self.units.position_unit())
    }

    /// The values of the set's own unknowns.
    pub(crate) fn own_values<T: Copy>(values: &[T; U]) -> [T; P] {
        S::UNKNOWNS.map(|own| {
            let place = F::UNKNOWNS.iter().position(|&unknown| unknown == own);
            values[place.unwrap_or(0)]
        })
    }

    /// The value of an unknown, SI.
    fn value(&self, values: &[N; P], wanted: Unknown) -> Option<f64> {
        let place = S::UNKNOWNS.iter().position(|&own| own == wanted)?;
        Some(values[place].to_f64() / wanted.scale(&self.units))
    }
}

impl<N, S, const P: usize, const W: usize, F, const U: usize> Identify<N>
    for WindowRecorder<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    type State = WindowRecorderState<N, U>;
    type Snapshot = WindowEstimates<N, P>;

    fn start(&self) -> Self::State {
        WindowRecorderState {
            recorder: Recorder::EMPTY,
            explained: None,
            at_bound: [false; U],
            event: Event::None,
            fits: 0,
        }
    }

    #[inline]
    fn increment(&self, moved: i32) -> N {
        N::from_count(moved)
    }

    #[inline]
    fn check(&self, increment: N, command: N) -> Result<(), StepError> {
        check(increment, command, self.longest)
    }

    /// Records the sample. The output error is that of the last sample of the last fit, and
    /// [`Event::Started`] reports a new one,
    /// [`Event::TermEntered`] one with another term, and [`Event::AtBound`] one that was not taken.
    #[inline]
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N> {
        state.recorder.push(&self.blocking, increment, command);
        let explained = &state.explained;
        Update {
            output_error: explained.map_or(N::ZERO, |explained| explained.output_error),
            event: core::mem::replace(&mut state.event, Event::None),
        }
    }

    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        WindowEstimates {
            values: match &state.explained {
                Some(explained) => Self::own_values(&explained.parameters),
                None => self.initial.map(N::from_f64),
            },
            at_bounds: Self::own_values(&state.at_bound),
        }
    }

    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        ModelValues::from_values::<S, P>(&shown.values)
            .parameters
            .to_si(&self.units)
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        PerParameter::from_fn(|wanted| {
            let mut own = S::UNKNOWNS.iter().zip(shown.at_bounds);
            own.any(|(&own, at)| own == wanted.into() && at)
        })
    }

    fn standard_errors(&self, state: &Self::State) -> Option<ServoParameters> {
        let deviations = Self::own_values(&state.explained.as_ref()?.deviations);
        let parameters = ModelValues::from_values::<S, P>(&deviations).parameters;
        Some(parameters.to_si(&self.units))
    }

    fn value_in(&self, shown: &Self::Snapshot, unknown: Unknown) -> Option<f64> {
        self.value(&shown.values, unknown)
    }

    fn standard_error_of(&self, state: &Self::State, unknown: Unknown) -> Option<f64> {
        let deviations = Self::own_values(&state.explained.as_ref()?.deviations);
        self.value(&deviations, unknown)
    }

    fn entered(&self, state: &Self::State) -> Terms {
        let explained = state.explained.as_ref();
        explained.map_or(Terms::NONE, |explained| explained.entered)
    }

    fn resume_moving(&self, state: &mut Self::State, _: N) {
        state.recorder.begin_anew();
    }
}

impl<N, S, const P: usize, const W: usize, F, const U: usize> RecordBlocks<N>
    for WindowRecorder<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    type Fitted = WindowFitted<N, U>;

    #[inline]
    fn take_block(&self, state: &mut Self::State) -> Option<NumberedBlock<N>> {
        state.recorder.take()
    }

    /// At once: the estimates are the new ones already before the next sample.
    #[inline]
    fn take_over(&self, state: &mut Self::State, fitted: &Self::Fitted) {
        if !state.recorder.has_recorded(fitted.last) {
            return;
        }
        state.at_bound = fitted.at_bound;
        state.event = match &fitted.explained {
            Some(explained) => {
                let entered = Identify::<N>::entered(self, state);
                state.explained = Some(*explained);
                state.fits = state.fits.saturating_add(1);
                if explained.entered == entered {
                    Event::Started
                } else {
                    Event::TermEntered
                }
            }
            None if state.explained.is_none() => Event::FirstFitOverdue,
            None if fitted.at_bound.contains(&true) => Event::AtBound,
            None => Event::NotFollowing,
        };
    }
}
