use core::marker::PhantomData;

use super::super::IdentifierError;
use super::super::fit::{Blocking, NumberedBlock, Recorder};
use super::super::halves::RecordBlocks;
use super::super::identify::{Event, Identify, Seen, check};
use super::super::settings::{Listening, place};
use super::fitter::WindowFitter;
use crate::error::StepError;
use crate::model::ServoParameters;
use crate::number::Number;
use crate::parameters::{ModelParameters, ParameterSet};
use crate::settings::{FromSettings, PerParameter, Settings};
use crate::units::Units;

/// The interrupt's half of the windowed identifier: it records for a window of W blocks, and holds the
/// last result of the [`WindowFitter`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowRecorder<N, S, const P: usize, const W: usize = 256> {
    blocking: Blocking<N>,
    units: Units,
    longest: N,
    initial: [f64; P],
    set: PhantomData<S>,
}

/// What the interrupt's half remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowRecorderState<N> {
    recorder: Recorder<N>,
    explained: Option<Explained<N>>,
    event: Event,
    fits: u32,
}

/// The result of a window fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowFitted<N> {
    /// The number of the last block that it used.
    pub(super) last: u32,
    /// None where the motion could not be explained.
    pub(super) explained: Option<Explained<N>>,
}

/// The result of a fit that explains the motion, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Explained<N> {
    /// a, b, c, d.
    pub(super) parameters: [N; 4],
    pub(super) deviations: [N; 4],
    pub(super) at_bound: [bool; 4],
    /// Variance of the fit's errors, counts².
    pub(super) unexplained: N,
    /// Of the last block, counts.
    pub(super) output_error: N,
}

/// The estimates of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowEstimates<N, const P: usize> {
    parameters: [N; P],
    at_bounds: [bool; P],
}

impl<N, S, const P: usize, const W: usize> FromSettings for WindowRecorder<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// # Errors
    /// See [`IdentifierError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, IdentifierError> {
        let config = Listening::new(settings)?;
        let fitter = config.fitter(
            |parameter| S::PARAMETERS.contains(&parameter),
            W,
            WindowFitter::<N, S, P, W>::TIME,
        )?;
        Ok(Self {
            blocking: Blocking::of(fitter.block),
            units: config.units,
            longest: config.longest_increment()?,
            initial: S::PARAMETERS.map(|parameter| fitter.initial[place(parameter)].unwrap_or(0.0)),
            set: PhantomData,
        })
    }
}

impl<N, S, const P: usize, const W: usize> WindowRecorder<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// Fits that have ended with a result.
    #[must_use]
    pub fn fits(&self, state: &WindowRecorderState<N>) -> u32 {
        state.fits
    }

    /// The standard deviation of the last fit's errors, rad; at least a count's rounding. None before
    /// the first fit.
    #[must_use]
    pub fn unexplained(&self, state: &WindowRecorderState<N>) -> Option<f64> {
        let explained = state.explained.as_ref()?;
        Some(libm::sqrt(explained.unexplained.to_f64()) * self.units.position_unit())
    }

    fn of_set<T: Copy>(values: &[T; 4]) -> [T; P] {
        S::PARAMETERS.map(|parameter| values[place(parameter)])
    }
}

impl<N, S, const P: usize, const W: usize> Identify<N> for WindowRecorder<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    type State = WindowRecorderState<N>;
    type Shown = WindowEstimates<N, P>;

    fn start(&self) -> Self::State {
        WindowRecorderState {
            recorder: Recorder::EMPTY,
            explained: None,
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
    /// [`Event::Started`] reports a new one.
    #[inline]
    fn follow(&self, state: &mut Self::State, increment: N, command: N) -> Seen<N> {
        state.recorder.push(&self.blocking, increment, command);
        let explained = &state.explained;
        Seen {
            output_error: explained.map_or(N::ZERO, |explained| explained.output_error),
            event: core::mem::replace(&mut state.event, Event::None),
        }
    }

    fn show(&self, state: &Self::State) -> Self::Shown {
        match &state.explained {
            Some(explained) => WindowEstimates {
                parameters: Self::of_set(&explained.parameters),
                at_bounds: Self::of_set(&explained.at_bound),
            },
            None => WindowEstimates {
                parameters: self.initial.map(N::from_f64),
                at_bounds: [false; P],
            },
        }
    }

    fn estimates_of(&self, shown: &Self::Shown) -> ServoParameters {
        ModelParameters::of_set::<S, P>(&shown.parameters).to_si(&self.units)
    }

    fn at_bounds_of(&self, shown: &Self::Shown) -> PerParameter<bool> {
        PerParameter::from_fn(|wanted| {
            let mut own = S::PARAMETERS.iter().zip(shown.at_bounds);
            own.any(|(&own, at)| own == wanted && at)
        })
    }

    fn standard_errors(&self, state: &Self::State) -> Option<ServoParameters> {
        let deviations = Self::of_set(&state.explained.as_ref()?.deviations);
        Some(ModelParameters::of_set::<S, P>(&deviations).to_si(&self.units))
    }

    fn join(&self, state: &mut Self::State, _: N) {
        state.recorder.begin_anew();
    }
}

impl<N, S, const P: usize, const W: usize> RecordBlocks<N> for WindowRecorder<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    type Fitted = WindowFitted<N>;

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
        if fitted.explained.is_some() {
            state.explained = fitted.explained;
            state.fits = state.fits.saturating_add(1);
            state.event = Event::Started;
        } else {
            state.event = Event::NotFollowing;
        }
    }
}
