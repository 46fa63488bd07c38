mod aside;
mod beginning;
mod learning;
mod load_step;
mod recursion;
mod settings;
mod standing;
mod start;

pub use start::Start;

use core::marker::PhantomData;

use load_step::LoadStepTest;
use recursion::{Mode, Recursion};

use super::fit::{Blocking, Fitter};
use super::identify::{Event, Identify, Seen, check};
use crate::adaptation::GaussNewton;
use crate::error::StepError;
use crate::model::{FrictionStep, ListeningModel, ServoParameters, Tangents};
use crate::number::Number;
use crate::parameters::{ModelParameters, ParameterSet};
use crate::settings::PerParameter;
use crate::units::Units;

/// The fast identifier: recursive Gauss–Newton on a model driven by the command that acted, for the
/// parameter set S. Its first fit uses a record of W blocks.
///
/// It begins by recording. Once the record tells enough, a fit in the background
/// ([`Identify::work`]) finds the servo without a first guess, and the recursion goes
/// on from there.
///
/// When an estimate moves, the model's state moves with it to where it would have been, to first
/// order, had the estimate always been the new one. The output error then is what the *present*
/// estimates leave unexplained, and nothing has to wait for the model to forget the old ones.
///
/// A step of the load is noticed by the mean of the output error. The recursion then pauses, and
/// the model itself, with an integral and a correction that is fast at first, finds the load; the
/// other estimates are not disturbed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonIdentifier<N, S, const P: usize, const W: usize = 256> {
    law: GaussNewton<N, P>,
    fitter: Fitter<N>,
    blocking: Blocking<N>,
    step: FrictionStep<N>,
    load_step: LoadStepTest<N>,
    units: Units,
    longest: N,
    /// ω T that was given.
    bandwidth: Option<N>,
    slowest: N,
    fastest: N,
    first: N,
    narrowing: N,
    block_narrowing: N,
    alongside: u16,
    search: u16,
    standing: u16,
    stood: u16,
    release: u16,
    alarm: u16,
    waiting: u16,
    reversal: u8,
    widening: N,
    unexplained: N,
    explained: N,
    bounded: N,
    widest: N,
    second: N,
    has_friction: bool,
    has_load: bool,
    free: [bool; P],
    initial: [f64; P],
    set: PhantomData<S>,
}

/// What the identifier remembers between samples.
///
/// What every sample needs comes first: a Cortex-M4F loads a float from within a kilobyte of a base
/// in one instruction, and from beyond it in two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct GaussNewtonIdentifierState<N: Number, const P: usize, const W: usize = 256> {
    recursion: Recursion<N, P>,
    start: Start<N, W>,
}

impl<N, S, const P: usize, const W: usize> GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// The time over which the first fit looks where nobody says, s.
    pub const START_TIME: f64 = 1.0;

    /// Velocity below which the model counts as standing, counts per sample.
    pub const DEAD_ZONE: f64 = 0.02;

    /// The largest ω T of the correction: the output error then stays within a few per cent of
    /// the encoder's.
    pub const WIDEST: f64 = 0.05;

    /// The slowest correction, rad/s.
    pub const SLOWEST: f64 = 3.0;

    /// The measured bandwidth is multiplied by this.
    pub const BANDWIDTH: f64 = 1.0;

    /// The correction when the model is put beside a moving servo or the load is sought, rad/s. It
    /// narrows as 1/ω = 1/ω₀ + t/6.
    pub const FASTEST: f64 = 300.0;

    /// 1/ω T grows by so much a sample then.
    const NARROWING: f64 = 1.0 / 6.0;

    /// The time in which the model joins the servo's motion, s.
    pub const JOINING: f64 = 0.1;

    /// The time for which the load is sought after a step, s.
    pub const SEARCH: f64 = 0.1;

    /// The time without a count after which the servo stands, s.
    pub const STANDING: f64 = 0.005;

    /// The time for which friction may hold the model while the servo moves, s.
    pub const HELD: f64 = 0.02;

    /// The time after which a step of the load is an event by itself, s. More than four within
    /// that time each are no steps of the load.
    pub const ALARM: f64 = 0.5;

    /// The time after a reversal in which a step of the load may as well be friction, s.
    pub const REVERSAL: f64 = 0.1;

    /// The time constant with which the correction widens where the output error is more than twice
    /// the encoder's, s: what the model lacks must not add up.
    pub const WIDENING: f64 = 0.5;

    /// The largest ω T of the correction then. The encoder's noise no longer matters.
    pub const UNEXPLAINED_WIDEST: f64 = 0.15;

    /// The time to wait before a servo that did not follow is believed again, s.
    pub const WAITING: f64 = 0.5;

    /// Bytes that the recursion itself keeps; the rest of the state is the record of the first fit
    /// and that fit.
    pub const RECURSION_BYTES: usize = size_of::<Recursion<N, P>>();

    /// Whether the recursion runs: a first fit has been found.
    #[must_use]
    pub fn is_running(&self, state: &GaussNewtonIdentifierState<N, P, W>) -> bool {
        !matches!(state.recursion.mode, Mode::Recording)
    }
}

impl<N, S, const P: usize, const W: usize> Identify<N> for GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    type State = GaussNewtonIdentifierState<N, P, W>;
    /// Machine units.
    type Shown = [N; P];

    fn start(&self) -> Self::State {
        GaussNewtonIdentifierState {
            recursion: Recursion {
                model: ListeningModel::alongside(N::ZERO),
                tangents: Tangents::NONE,
                law: self
                    .law
                    .start(&self.initial.map(N::from_f64), &[[0.0; P]; P]),
                response: self.step.step.response(N::ZERO),
                omega: N::ZERO,
                measured: N::ZERO,
                quick: N::ZERO,
                scale: N::ZERO,
                suspicion: self.load_step.start(N::ZERO),
                mean_square: N::ZERO,
                trusted_load: N::ZERO,
                last_move: N::ZERO,
                slid: N::ZERO,
                held: 0,
                still: 0,
                alarm: 0,
                left: 0,
                straight: 0,
                mode: Mode::Recording,
                lacking: false,
                ambiguous: false,
            },
            start: Start::new(),
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

    #[inline]
    fn follow(&self, state: &mut Self::State, increment: N, command: N) -> Seen<N> {
        if state.start.is_recording() {
            return self.record(state, increment, command);
        }
        let seen = self.run(&mut state.recursion, increment, command);
        if seen.event == Event::Restarted {
            state.start.clear();
        }
        seen
    }

    #[inline]
    fn show(&self, state: &Self::State) -> Self::Shown {
        state.recursion.law.estimates()
    }

    fn estimates_of(&self, shown: &Self::Shown) -> ServoParameters {
        ModelParameters::of_set::<S, P>(shown).to_si(&self.units)
    }

    fn standard_errors(&self, state: &Self::State) -> Option<ServoParameters> {
        if matches!(state.recursion.mode, Mode::Recording) && state.recursion.omega == N::ZERO {
            return None;
        }
        let errors = self.law.standard_errors(&state.recursion.law);
        Some(ModelParameters::of_set::<S, P>(&errors.map(N::from_f64)).to_si(&self.units))
    }

    /// None before there is a model.
    fn bandwidth(&self, state: &Self::State) -> Option<f64> {
        let omega = state.recursion.omega.to_f64() / self.units.sample_time();
        (omega > 0.0).then_some(omega)
    }

    fn at_bounds_of(&self, shown: &Self::Shown) -> PerParameter<bool> {
        let at = self.law.at_bounds(shown);
        PerParameter::from_fn(|wanted| {
            let own = S::PARAMETERS.iter().position(|&own| own == wanted);
            own.is_some_and(|i| at[i] && self.free[i])
        })
    }

    fn join(&self, state: &mut Self::State, increment: N) {
        if state.start.is_recording() {
            state.start.clear();
        }
        if !matches!(state.recursion.mode, Mode::Recording) {
            self.rejoin(&mut state.recursion, increment);
        }
    }

    fn work(&self, state: &mut Self::State, budget: u32) {
        if state.start.is_recording() {
            state.start.work(&self.fitter, budget);
        }
    }
}

fn last<N: Number, const P: usize>(values: &[N; P]) -> N {
    values.last().copied().unwrap_or(N::ZERO)
}
