use super::memory::{GradientMemory, GradientMemoryState};
use super::recursion::{GradientEstimates, GradientRecursion, GradientRecursionState};
use crate::constants::{Encode, encode};
use crate::error::StepError;
use crate::identify::{Identify, MachineEstimates, Report, Update};
use crate::measurement::velocity::VelocityEstimate;
use crate::number::{Arithmetic, Encoded};
use crate::parameters::{Parameter, ParameterSet, PerParameter, ServoParameters};

/// The paper's estimator with a memory, for the parameter set S: a [`GradientRecursion`] and its [`GradientMemory`].
///
/// The memory works in the background ([`Identify::work`]); without that it is the paper's estimator alone. A chip whose
/// interrupt must be short uses the two halves separately.
///
/// In fixed point increments and commands are fractions of full scales that follow from the settings.
/// [`Identify::increment`] converts counts, [`GradientRecursion::command_word`] command units. A controller built from
/// the same settings has the same full scales.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientIdentifier<N: Arithmetic, V, S, const P: usize> {
    pub(crate) recursion: GradientRecursion<N, V, S, P>,
    pub(crate) memory: GradientMemory<N>,
}

encode! {
    [N: Encoded, V: Encode, S: ParameterSet<P>, const P: usize]
    GradientIdentifier<N, V, S, P> as "GradientIdentifier" { recursion, memory }
}

/// State of both halves. What every sample needs comes first.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct GradientIdentifierState<N: Arithmetic, F, const P: usize> {
    recursion: GradientRecursionState<N, F, P>,
    memory: GradientMemoryState<N::Real>,
}

/// The interrupt's half, whose settings and conversions are those of the whole.
impl<N: Arithmetic, V, S, const P: usize> core::ops::Deref for GradientIdentifier<N, V, S, P> {
    type Target = GradientRecursion<N, V, S, P>;

    fn deref(&self) -> &Self::Target {
        &self.recursion
    }
}

impl<N, V, S, const P: usize> Identify<N> for GradientIdentifier<N, V, S, P>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    type State = GradientIdentifierState<N, V::State, P>;
    type Snapshot = GradientEstimates<N, P>;

    fn start(&self) -> Self::State {
        GradientIdentifierState {
            recursion: self.recursion.start(),
            memory: self.memory.start(),
        }
    }

    #[inline]
    fn increment(&self, moved: i32) -> N {
        self.recursion.increment(moved)
    }

    #[inline]
    fn check(&self, increment: N, command: N) -> Result<(), StepError> {
        self.recursion.check(increment, command)
    }

    #[inline(always)]
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N> {
        self.recursion
            .update(&mut state.recursion, increment, command)
    }

    #[inline]
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        self.recursion.snapshot(&state.recursion)
    }

    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        self.recursion.estimates_in(shown)
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        self.recursion.at_bounds_in(shown)
    }

    fn report(&self, state: &Self::State) -> Report {
        self.memory.report(&state.memory)
    }

    fn resume_moving(&self, state: &mut Self::State, increment: N) {
        self.recursion
            .resume_moving(&mut state.recursion, increment);
    }

    /// Remembers the piece of the motion that the last samples completed.
    fn work(&self, state: &mut Self::State, _: u32) {
        let Some(piece) = self.recursion.take_piece(&mut state.recursion) else {
            return;
        };
        let estimates = self.recursion.machine_estimates(&state.recursion);
        if let Some(correction) = (self.memory).process(&mut state.memory, &piece, &estimates) {
            self.recursion.take_over(&mut state.recursion, &correction);
        }
    }
}

impl<N, V, S, const P: usize> MachineEstimates<N> for GradientIdentifier<N, V, S, P>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    #[inline]
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N> {
        self.recursion.machine_estimates(&state.recursion)
    }

    fn machine_unit(&self, parameter: Parameter) -> f64 {
        self.recursion.machine_unit(parameter)
    }
}
