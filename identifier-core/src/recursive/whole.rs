use super::first_fit::GaussNewtonFitterState;
use super::interrupt::GaussNewtonRecursionState;
use super::recursion::Recursion;
use super::{GaussNewtonFitter, GaussNewtonRecursion, PreparedServo, SettledEstimates};
use crate::constants::{Encode, encode};
use crate::error::StepError;
use crate::identify::{Identify, MachineEstimates, Report, Update};
use crate::model::IdentifiableSet;
use crate::number::Number;
use crate::parameters::{Parameter, PerParameter, ServoParameters, Unknown};

/// The fast identifier: recursive Gauss–Newton on a model driven by the command that acted, for the
/// parameter set S. Its first fit uses a record of W blocks.
///
/// It begins by recording. Once the record carries enough information, a fit in the background
/// ([`Identify::work`]) identifies the servo without a first guess. The recursion continues from
/// it.
///
/// It consists of two halves, between which it passes on blocks and fit results at once. It is for a PC, and for
/// firmwares with enough time. A chip whose interrupt records while its background fits uses [`GaussNewtonRecursion`]
/// and [`GaussNewtonFitter`] separately.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonIdentifier<N, S, const P: usize, const W: usize = 256> {
    pub(crate) recorder: GaussNewtonRecursion<N, S, P, W>,
    pub(crate) fitter: GaussNewtonFitter<N, S, P, W>,
}

encode! {
    [N: Encode, S: IdentifiableSet<P>, const P: usize, const W: usize]
    GaussNewtonIdentifier<N, S, P, W> as "GaussNewtonIdentifier" { recorder, fitter }
}

/// State of both halves.
///
/// The fields that every sample needs come first. A Cortex-M4F loads a float within a kilobyte of a base in one
/// instruction, and beyond it in two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct GaussNewtonIdentifierState<
    N: Number,
    S: IdentifiableSet<P>,
    const P: usize,
    const W: usize = 256,
> {
    recorder: GaussNewtonRecursionState<N, S, P>,
    fitter: GaussNewtonFitterState<N, W>,
}

impl<N, S, const P: usize, const W: usize> GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// Bytes of the recursion itself. The rest of the state is the first fit and its record.
    pub const RECURSION_BYTES: usize = size_of::<Recursion<N, S, P>>();

    /// The half that records.
    #[must_use]
    pub fn recorder(&self) -> &GaussNewtonRecursion<N, S, P, W> {
        &self.recorder
    }

    /// Starts from a known servo, without a first fit. See [`GaussNewtonRecursion::prepare`].
    #[must_use]
    pub fn start_from(&self, known: &PreparedServo<N>) -> GaussNewtonIdentifierState<N, S, P, W> {
        GaussNewtonIdentifierState {
            recorder: self.recorder.start_from(known),
            fitter: self.fitter.start(),
        }
    }

    /// True if the recursion runs: the first fit has succeeded.
    #[must_use]
    pub fn is_running(&self, state: &GaussNewtonIdentifierState<N, S, P, W>) -> bool {
        self.recorder.is_running(&state.recorder)
    }

    /// See [`GaussNewtonRecursion::check_estimates`].
    pub fn check_estimates(&self, state: &mut GaussNewtonIdentifierState<N, S, P, W>) {
        self.recorder.check_estimates(&mut state.recorder);
    }

    /// See [`GaussNewtonRecursion::settled`].
    #[must_use]
    pub fn settled(
        &self,
        state: &GaussNewtonIdentifierState<N, S, P, W>,
    ) -> Option<SettledEstimates<N, P>> {
        self.recorder.settled(&state.recorder)
    }
}

impl<N, S, const P: usize, const W: usize> Identify<N> for GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    type State = GaussNewtonIdentifierState<N, S, P, W>;
    type Snapshot = [N; P];

    fn start(&self) -> Self::State {
        GaussNewtonIdentifierState {
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
        if let Some(block) = self.recorder.take_block(&mut state.recorder) {
            self.fitter.take(&mut state.fitter, &block);
        }
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

    fn report(&self, state: &Self::State) -> Report {
        Report {
            rejection_reason: self.fitter.rejection_reason(&state.fitter),
            noise: self.fitter.noise(&state.fitter),
            ..self.recorder.report(&state.recorder)
        }
    }

    fn place(&self, state: &mut Self::State, position: N) {
        self.recorder.place(&mut state.recorder, position);
    }

    fn resume_moving(&self, state: &mut Self::State, increment: N) {
        self.recorder.resume_moving(&mut state.recorder, increment);
        self.fitter.begin_anew(&mut state.fitter);
    }

    /// Continues a fit by at most `budget` blocks.
    fn work(&self, state: &mut Self::State, budget: u32) {
        if let Some(fitted) = self.fitter.work(&mut state.fitter, budget) {
            self.recorder.take_over(&mut state.recorder, &fitted);
        }
    }
}

impl<N, S, const P: usize, const W: usize> MachineEstimates<N> for GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    #[inline]
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N> {
        self.recorder.machine_estimates(&state.recorder)
    }

    fn machine_unit(&self, parameter: Parameter) -> f64 {
        self.recorder.machine_unit(parameter)
    }
}
