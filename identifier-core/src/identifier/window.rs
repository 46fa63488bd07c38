use core::marker::PhantomData;

use super::IdentifierError;
use super::fit::{Blocking, Fit, Fitter, Found, Prior, Record};
use super::identify::{Event, Identify, Seen, check};
use super::settings::{Listening, place};
use crate::error::StepError;
use crate::model::ServoParameters;
use crate::number::Number;
use crate::parameters::{ModelParameters, ParameterSet};
use crate::settings::{FromSettings, PerParameter, Settings};
use crate::units::Units;

/// The windowed identifier: Levenberg–Marquardt passes of the model, driven by the recorded command,
/// over the last W blocks of samples, for the parameter set S; load and friction are parameters of
/// their own, and the model's initial position and velocity are fitted with them.
///
/// A window looks at the same samples again and again, so it knows a servo after a wiggle of a sixth
/// of a second, from no first guess. [`IdentifierSettings::start_time`](crate::settings::IdentifierSettings::start_time) is the time it spans; what a
/// fit found is known before the next. The work is cut into slices
/// ([`Identify::work`]) and never delays a sample. Nothing is fitted to a servo that does
/// not move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowIdentifier<N, S, const P: usize, const W: usize = 256> {
    fitter: Fitter<N>,
    blocking: Blocking<N>,
    units: Units,
    longest: N,
    initial: [f64; P],
    set: PhantomData<S>,
}

/// The estimates of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowEstimates<N, const P: usize> {
    parameters: [N; P],
    at_bounds: [bool; P],
}

/// What the identifier remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowState<N: Number, const W: usize = 256> {
    record: Record<N, W>,
    fresh: usize,
    fit: Option<Fit<N>>,
    found: Option<Found<N>>,
    event: Event,
    fits: u32,
}

impl<N, S, const P: usize, const W: usize> FromSettings for WindowIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// # Errors
    /// See [`IdentifierError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, IdentifierError> {
        const {
            assert!(
                W >= Self::LEAST_BLOCKS,
                "a window of fewer blocks tells too little"
            )
        };
        let config = Listening::new(settings)?;
        let fitter = config.fitter::<S, P>(W, Self::TIME)?;
        let initial =
            S::PARAMETERS.map(|parameter| fitter.initial[place(parameter)].unwrap_or(0.0));
        Ok(Self {
            blocking: Blocking::of(fitter.block),
            fitter: Fitter::new(&fitter),
            units: config.units,
            longest: config.longest_increment()?,
            initial,
            set: PhantomData,
        })
    }
}

impl<N, S, const P: usize, const W: usize> WindowIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// The time that the window spans where nobody says, s.
    pub const TIME: f64 = 0.5;

    /// Blocks that the first fit needs.
    pub const LEAST_BLOCKS: usize = 32;

    /// How uncertain b may be, as a part of itself, for a fit to count.
    pub const UNCERTAIN: f64 = 0.2;

    fn prior(&self, state: &WindowState<N, W>) -> Prior<N> {
        match &state.found {
            Some(found) => self.fitter.known_from(found),
            None => self.fitter.given(),
        }
    }

    /// Fits that have ended with a result.
    #[must_use]
    pub fn fits(&self, state: &WindowState<N, W>) -> u32 {
        state.fits
    }

    /// Whether a fit is under way.
    #[must_use]
    pub fn is_fitting(&self, state: &WindowState<N, W>) -> bool {
        state.fit.is_some()
    }

    /// The standard deviation of what the last fit could not explain, rad; at least a count's
    /// rounding. None before the first fit.
    #[must_use]
    pub fn unexplained(&self, state: &WindowState<N, W>) -> Option<f64> {
        let found = state.found.as_ref()?;
        Some(libm::sqrt(found.unexplained.to_f64()) * self.units.position_unit())
    }

    fn of_set(values: &[N; 4]) -> [N; P] {
        S::PARAMETERS.map(|parameter| values[place(parameter)])
    }
}

impl<N, S, const P: usize, const W: usize> Identify<N> for WindowIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    type State = WindowState<N, W>;
    type Shown = WindowEstimates<N, P>;

    fn start(&self) -> Self::State {
        WindowState {
            record: Record::empty(),
            fresh: 0,
            fit: None,
            found: None,
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
    /// [`Event::Started`] says that there is a new one.
    #[inline]
    fn follow(&self, state: &mut Self::State, increment: N, command: N) -> Seen<N> {
        if state.record.push(&self.blocking, increment, command) {
            state.fresh += 1;
        }
        Seen {
            output_error: state.found.map_or(N::ZERO, |found| found.output_error),
            event: core::mem::replace(&mut state.event, Event::None),
        }
    }

    fn show(&self, state: &Self::State) -> Self::Shown {
        match &state.found {
            Some(found) => WindowEstimates {
                parameters: Self::of_set(&found.parameters),
                at_bounds: S::PARAMETERS.map(|parameter| found.at_bound[place(parameter)]),
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

    fn standard_errors(&self, state: &Self::State) -> Option<ServoParameters> {
        let found = state.found.as_ref()?;
        let deviations =
            core::array::from_fn(|i| N::from_f64(libm::sqrt(found.covariance[i][i].to_f64())));
        Some(ModelParameters::of_set::<S, P>(&Self::of_set(&deviations)).to_si(&self.units))
    }

    fn at_bounds_of(&self, shown: &Self::Shown) -> PerParameter<bool> {
        PerParameter::from_fn(|wanted| {
            let mut own = S::PARAMETERS.iter().zip(shown.at_bounds);
            own.any(|(&own, at)| own == wanted && at)
        })
    }

    fn join(&self, state: &mut Self::State, _: N) {
        state.record.release();
        state.record.clear();
        state.fresh = 0;
        state.fit = None;
    }

    /// Goes on with the fit that is under way by at most `budget` blocks, or begins one as soon as a
    /// sixteenth of the window is new. On a PC call it after every sample, on a chip in the background.
    fn work(&self, state: &mut Self::State, budget: u32) {
        if state.fit.is_none() {
            let blocks = state.record.len();
            if blocks < Self::LEAST_BLOCKS || state.fresh < (blocks / 32).max(2) {
                return;
            }
            state.fresh = 0;
            state.record.hold();
            state.fit = Some(self.fitter.begin(blocks, self.prior(state)));
        }
        let Some(fit) = &mut state.fit else { return };
        for _ in 0..budget {
            if let Some(result) = self.fitter.work(fit, &state.record) {
                state.fit = None;
                state.record.release();
                match result {
                    Some(found) if found.is_good(Self::UNCERTAIN) => {
                        state.event = Event::Started;
                        state.fits = state.fits.saturating_add(1);
                        state.found = Some(found);
                    }
                    Some(_) if state.record.is_full() => state.event = Event::NotFollowing,
                    _ => {}
                }
                return;
            }
        }
    }
}
