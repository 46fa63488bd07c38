use super::GaussNewtonRecursion;
use super::fitted::GaussNewtonFitted;
use super::recursion::{Entered, Mode, Recursion};
use super::uncertainty::EstimateUncertainty;
use crate::error::StepError;
use crate::fit::{NumberedBlock, Recorder};
use crate::identify::{Event, Identify, MachineEstimates, Report, Update, check};
use crate::model::{IdentifiableSet, KnownInputs, ModelValues};
use crate::number::Number;
use crate::parameters::{Parameter, PerParameter, ServoParameters, Unknown};

/// Estimates of a recursion that has settled, with their errors, machine units. See [`GaussNewtonRecursion::settled`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SettledEstimates<N, const P: usize> {
    values: [N; P],
    uncertainty: EstimateUncertainty<N, P>,
}

/// The state of the interrupt's half between samples; the fields that every sample needs come first.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct GaussNewtonRecursionState<N: Number, S: IdentifiableSet<P>, const P: usize> {
    pub(super) recursion: Recursion<N, S, P>,
    /// Samples are recorded for a fit.
    pub(super) recording: bool,
    /// The fit is to replace the estimates, and not only to check them.
    pub(super) is_uncertain: bool,
    /// b of the last fit, if that contradicted the estimates; zero for none.
    pub(super) contradiction: N,
    pub(super) recorder: Recorder<N>,
    /// The fit result from which the next sample continues.
    pub(super) fitted: Option<GaussNewtonFitted<N>>,
    /// The unexplained part of the fit that the recursion started from.
    pub(super) usual: N,
}

impl<N: Number, S: IdentifiableSet<P>, const P: usize> GaussNewtonRecursionState<N, S, P> {
    /// Begins a new recording.
    pub(super) fn record_anew(&mut self) {
        self.recorder.begin_anew();
        self.fitted = None;
        self.recording = true;
    }
}

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// True if the recursion runs: the first fit has succeeded.
    #[must_use]
    pub fn is_running(&self, state: &GaussNewtonRecursionState<N, S, P>) -> bool {
        !matches!(state.recursion.mode, Mode::Recording)
    }

    /// Starts a fit to the motion from here on that checks the estimates. They must have [settled](Self::settled), and
    /// no other fit may be checking them. If a second fit confirms that they are wrong, the recursion continues from
    /// it. A recursion with small standard errors follows a change slowly if its correction hides the change.
    pub fn check_estimates(&self, state: &mut GaussNewtonRecursionState<N, S, P>) {
        if state.recursion.mode == Mode::Learning && !state.recording {
            state.record_anew();
            state.is_uncertain = false;
        }
    }

    /// The estimates and their errors. None unless the recursion learns all unknowns and trusts its estimates. A copy
    /// without a root or a division, for the background to convert.
    #[must_use]
    pub fn settled(
        &self,
        state: &GaussNewtonRecursionState<N, S, P>,
    ) -> Option<SettledEstimates<N, P>> {
        let is_settled =
            state.recursion.mode == Mode::Learning && !(state.recording && state.is_uncertain);
        is_settled.then(|| SettledEstimates {
            values: state.recursion.law.estimates(),
            uncertainty: self.law.uncertainty(&state.recursion.law),
        })
    }

    /// Settled estimates and their standard errors, SI.
    #[must_use]
    pub fn settled_in(&self, settled: &SettledEstimates<N, P>) -> [ServoParameters; 2] {
        let errors = settled.uncertainty.standard_errors().map(N::from_f64);
        [settled.values, errors].map(|values| self.estimates_in(&values))
    }

    /// The block that the last sample completed, if it did. One that is not taken before the next is
    /// complete is lost.
    #[inline]
    pub fn take_block(
        &self,
        state: &mut GaussNewtonRecursionState<N, S, P>,
    ) -> Option<NumberedBlock<N>> {
        state.recorder.take()
    }

    /// Takes over a fit result: the next sample continues from it, and reports [`Event::Started`].
    #[inline]
    pub fn take_over(
        &self,
        state: &mut GaussNewtonRecursionState<N, S, P>,
        fitted: &GaussNewtonFitted<N>,
    ) {
        if state.recording && state.recorder.has_recorded(fitted.last) {
            state.fitted = Some(*fitted);
        }
    }
}

impl<N, S, const P: usize, const W: usize> Identify<N> for GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    type State = GaussNewtonRecursionState<N, S, P>;
    /// Machine units.
    type Snapshot = [N; P];

    fn start(&self) -> Self::State {
        GaussNewtonRecursionState {
            recursion: Recursion::new(
                self.law.start(&self.initial.map(N::from_f64)),
                S::Inputs::<N>::START,
                Entered::NONE,
                self.step.step.response(N::ZERO),
                self.load_step.start(N::ZERO),
            ),
            recorder: Recorder::default(),
            fitted: None,
            usual: N::ZERO,
            recording: true,
            is_uncertain: true,
            contradiction: N::ZERO,
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
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N> {
        let acting = self.acting(&mut state.recursion, increment, command);
        if state.recording {
            return self.record(state, increment, &acting);
        }
        let seen = self.run(&mut state.recursion, increment, &acting);
        if seen.event == Event::Restarted {
            state.record_anew();
            state.is_uncertain = true;
        }
        seen
    }

    #[inline]
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        state.recursion.law.estimates()
    }

    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        ModelValues::from_values::<S, P>(shown)
            .parameters
            .to_si(&self.units)
    }

    fn value_in(&self, shown: &Self::Snapshot, unknown: Unknown) -> Option<f64> {
        let i = S::UNKNOWNS.iter().position(|&own| own == unknown)?;
        Some(shown.get(i)?.to_f64() / unknown.scale(&self.units))
    }

    fn report(&self, state: &Self::State) -> Report {
        let recursion = &state.recursion;
        let has_estimates = self.is_running(state) || recursion.omega != N::ZERO;
        let mut standard_errors = [None; Unknown::COUNT];
        if has_estimates {
            let errors = self.law.uncertainty(&recursion.law).standard_errors();
            for (unknown, error) in S::UNKNOWNS.into_iter().zip(errors) {
                standard_errors[unknown as usize] = Some(error / unknown.scale(&self.units));
            }
        }
        let omega = recursion.omega.to_f64() / self.units.sample_time();
        Report {
            has_estimates,
            standard_errors,
            entered: recursion.entered.terms,
            bandwidth: (omega > 0.0).then_some(omega),
            ..Report::default()
        }
    }

    fn place(&self, state: &mut Self::State, position: N) {
        state.recursion.inputs.place(&self.angle, position);
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        let at = self.law.at_bounds(shown);
        PerParameter::from_fn(|wanted| {
            let own = S::UNKNOWNS.iter().position(|&own| own == wanted.into());
            own.is_some_and(|i| at[i] && self.free[i])
        })
    }

    fn resume_moving(&self, state: &mut Self::State, increment: N) {
        if state.recording {
            state.record_anew();
        }
        if !matches!(state.recursion.mode, Mode::Recording) {
            self.rejoin(&mut state.recursion, increment);
        }
    }
}

impl<N, S, const P: usize, const W: usize> MachineEstimates<N> for GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    #[inline]
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N> {
        self.values(&state.recursion).parameters.per_parameter()
    }

    fn machine_unit(&self, parameter: Parameter) -> f64 {
        1.0 / parameter.scale(&self.units)
    }
}
