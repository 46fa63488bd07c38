use super::identify::{Identify, Update};
use crate::constants::{Encode, encode};
use crate::control::ControlSample;
use crate::error::StepError;
use crate::model::{Amplifier, AmplifierState};
use crate::number::Number;
use crate::parameters::{PerParameter, ServoParameters, Terms, Unknown};
use crate::reason::Reason;

/// An identifier behind the declared amplifier. It gets the commands that act on the servo behind dead band, delay and
/// current loop. L is the length of the ring of commands, a power of two; the delay may be L − 2 samples.
///
/// Declared effects that are not estimated act here, for every estimator. A declared delay or dead band may also be a
/// term to be estimated. It is then the initial value of the estimate, in the identifier. So nothing counts twice, and
/// a report gives the total.
///
/// ```
/// use identifier_core::Settings;
/// use identifier_core::identifier::{BehindAmplifier, GaussNewtonIdentifier};
/// use identifier_core::parameters::Unknowns;
///
/// let mut settings = Settings::new(1e-3, 10_000.0);
/// settings.identifier.terms.delay = 1.6e-3;
/// let identifier: BehindAmplifier<f32, GaussNewtonIdentifier<f32, Unknowns<4>, 4>, 8> =
///     settings.build()?;
/// # Ok::<(), identifier_core::settings::SettingsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BehindAmplifier<N, I, const L: usize> {
    pub(crate) amplifier: Amplifier<N>,
    pub(crate) identifier: I,
}

encode! {
    [N: Encode, I: Encode, const L: usize] BehindAmplifier<N, I, L> as "BehindAmplifier" { amplifier, identifier }
    also L as u32
}

/// State of amplifier and identifier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BehindAmplifierState<N, T, const L: usize> {
    amplifier: AmplifierState<N, L>,
    identification: T,
}

impl<N, T, const L: usize> BehindAmplifierState<N, T, L> {
    /// State of the identifier.
    #[must_use]
    pub fn identification(&self) -> &T {
        &self.identification
    }

    /// The same, to be changed.
    pub fn identification_mut(&mut self) -> &mut T {
        &mut self.identification
    }
}

impl<N, I, const L: usize> BehindAmplifier<N, I, L> {
    /// The identifier.
    #[must_use]
    pub fn identifier(&self) -> &I {
        &self.identifier
    }
}

impl<N: Number, I: Identify<N>, const L: usize> Identify<N> for BehindAmplifier<N, I, L> {
    type State = BehindAmplifierState<N, I::State, L>;
    type Snapshot = I::Snapshot;

    fn start(&self) -> Self::State {
        BehindAmplifierState {
            amplifier: AmplifierState::START,
            identification: self.identifier.start(),
        }
    }

    #[inline]
    fn increment(&self, moved: i32) -> N {
        self.identifier.increment(moved)
    }

    #[inline]
    fn check(&self, increment: N, command: N) -> Result<(), StepError> {
        self.identifier.check(increment, command)
    }

    #[inline]
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N> {
        let acts = self.amplifier.process(&mut state.amplifier, command);
        self.identifier
            .update(&mut state.identification, increment, acts)
    }

    #[inline]
    fn update_with_velocity(
        &self,
        state: &mut Self::State,
        sample: &ControlSample<N>,
    ) -> Update<N> {
        let command = self.amplifier.process(&mut state.amplifier, sample.command);
        let sample = ControlSample { command, ..*sample };
        self.identifier
            .update_with_velocity(&mut state.identification, &sample)
    }

    #[inline]
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        self.identifier.snapshot(&state.identification)
    }

    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        self.identifier.estimates_in(shown)
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        self.identifier.at_bounds_in(shown)
    }

    fn has_estimates(&self, state: &Self::State) -> bool {
        self.identifier.has_estimates(&state.identification)
    }

    fn value_in(&self, shown: &Self::Snapshot, unknown: Unknown) -> Option<f64> {
        self.identifier.value_in(shown, unknown)
    }

    fn standard_error_of(&self, state: &Self::State, unknown: Unknown) -> Option<f64> {
        self.identifier
            .standard_error_of(&state.identification, unknown)
    }

    fn entered(&self, state: &Self::State) -> Terms {
        self.identifier.entered(&state.identification)
    }

    fn obstacle(&self, state: &Self::State) -> Option<Reason> {
        self.identifier.obstacle(&state.identification)
    }

    fn noise(&self, state: &Self::State) -> Option<f64> {
        self.identifier.noise(&state.identification)
    }

    fn place(&self, state: &mut Self::State, position: N) {
        self.identifier.place(&mut state.identification, position);
    }

    fn bandwidth(&self, state: &Self::State) -> Option<f64> {
        self.identifier.bandwidth(&state.identification)
    }

    fn work(&self, state: &mut Self::State, budget: u32) {
        self.identifier.work(&mut state.identification, budget);
    }

    fn resume_moving(&self, state: &mut Self::State, increment: N) {
        self.identifier
            .resume_moving(&mut state.identification, increment);
    }
}
