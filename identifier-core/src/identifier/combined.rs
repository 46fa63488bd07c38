use super::MachineEstimates;
use super::halves::{FitBlocks, RecordBlocks};
use super::identify::{Identify, Update};
use crate::constants::{Encode, encode};
use crate::error::StepError;
use crate::parameters::{Parameter, PerParameter, ServoParameters, Terms, Unknown};
use crate::reason::Reason;

/// Both halves of an identifier that fits, as one, for a PC and for firmwares with enough time. Blocks and fit results
/// are passed on at once. [`Identify::work`] is the fitter's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Combined<R, F> {
    pub(crate) recorder: R,
    pub(crate) fitter: F,
}

encode! {
    [R: Encode, F: Encode] Combined<R, F> as "Combined" { recorder, fitter }
}

/// State of both halves.
///
/// The fields that every sample needs come first. A Cortex-M4F loads a float within a kilobyte of a base in one
/// instruction, and beyond it in two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct CombinedState<A, B> {
    pub(super) recorder: A,
    pub(super) fitter: B,
}

impl<R, F> Combined<R, F> {
    /// The half that records.
    #[must_use]
    pub fn recorder(&self) -> &R {
        &self.recorder
    }

    /// The half that fits.
    #[must_use]
    pub fn fitter(&self) -> &F {
        &self.fitter
    }
}

impl<R, F> Combined<R, F> {
    /// Passes the block that a sample completed to the fitter.
    #[inline]
    fn pass_on<N: Copy>(&self, state: &mut CombinedState<R::State, F::State>)
    where
        R: RecordBlocks<N>,
        F: FitBlocks<N>,
    {
        if let Some(block) = self.recorder.take_block(&mut state.recorder) {
            self.fitter.take(&mut state.fitter, &block);
        }
    }
}

impl<N, R, F> Identify<N> for Combined<R, F>
where
    N: Copy,
    R: RecordBlocks<N>,
    F: FitBlocks<N, Fitted = R::Fitted>,
{
    type State = CombinedState<R::State, F::State>;
    type Snapshot = R::Snapshot;

    fn start(&self) -> Self::State {
        CombinedState {
            recorder: self.recorder.start(),
            fitter: self.fitter.start(),
        }
    }

    #[inline]
    fn increment(&self, moved: i32) -> N {
        self.recorder.increment(moved)
    }

    #[inline]
    fn check(&self, increment: N, command: N) -> Result<(), StepError> {
        self.recorder.check(increment, command)
    }

    #[inline]
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N> {
        let seen = self
            .recorder
            .update(&mut state.recorder, increment, command);
        self.pass_on(state);
        seen
    }

    #[inline]
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        self.recorder.snapshot(&state.recorder)
    }

    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        self.recorder.estimates_in(shown)
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        self.recorder.at_bounds_in(shown)
    }

    fn value_in(&self, shown: &Self::Snapshot, unknown: Unknown) -> Option<f64> {
        self.recorder.value_in(shown, unknown)
    }

    fn standard_error_of(&self, state: &Self::State, unknown: Unknown) -> Option<f64> {
        self.recorder.standard_error_of(&state.recorder, unknown)
    }

    fn entered(&self, state: &Self::State) -> Terms {
        self.recorder.entered(&state.recorder)
    }

    fn rejection_reason(&self, state: &Self::State) -> Option<Reason> {
        self.fitter.rejection_reason(&state.fitter)
    }

    fn noise(&self, state: &Self::State) -> Option<f64> {
        self.fitter.noise(&state.fitter)
    }

    fn place(&self, state: &mut Self::State, position: N) {
        self.recorder.place(&mut state.recorder, position);
    }

    fn has_estimates(&self, state: &Self::State) -> bool {
        self.recorder.has_estimates(&state.recorder)
    }

    fn bandwidth(&self, state: &Self::State) -> Option<f64> {
        self.recorder.bandwidth(&state.recorder)
    }

    fn resume_moving(&self, state: &mut Self::State, increment: N) {
        self.recorder.resume_moving(&mut state.recorder, increment);
        self.fitter.begin_anew(&mut state.fitter);
    }

    /// Continues a fit by at most `budget` blocks. On a PC call it after every sample, on a chip in
    /// the background.
    fn work(&self, state: &mut Self::State, budget: u32) {
        if let Some(fitted) = self.fitter.work(&mut state.fitter, budget) {
            self.recorder.take_over(&mut state.recorder, &fitted);
        }
    }
}

impl<N, R, F> MachineEstimates<N> for Combined<R, F>
where
    N: Copy,
    R: RecordBlocks<N> + MachineEstimates<N>,
    F: FitBlocks<N, Fitted = R::Fitted>,
{
    #[inline]
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N> {
        self.recorder.machine_estimates(&state.recorder)
    }

    fn machine_unit(&self, parameter: Parameter) -> f64 {
        self.recorder.machine_unit(parameter)
    }
}
