use crate::error::StepError;
use crate::model::ServoParameters;
use crate::number::Number;

/// An identifier that only listens: two numbers a sample, how far the encoder moved since the last
/// sample and the command that acts from now until the next.
///
/// Nothing of the controller enters: not its reference, structure, limit or anti-windup.
pub trait Identify<N: Number> {
    /// What it remembers between samples.
    type State: Clone + core::fmt::Debug;

    /// The state before the first sample.
    fn start(&self) -> Self::State;

    /// One sample.
    ///
    /// `increment`: position moved since the last sample, counts. `command`: total command held
    /// from this sample to the next, command units.
    ///
    /// # Errors
    /// [`StepError::CommandNotFinite`] and [`StepError::CountJumped`]; the state is then as it was.
    fn learn(
        &self,
        state: &mut Self::State,
        increment: N,
        command: N,
    ) -> Result<Seen<N>, StepError>;

    /// The estimates, SI.
    fn estimates(&self, state: &Self::State) -> ServoParameters;

    /// Their standard errors, SI; none before anything was learnt.
    fn standard_errors(&self, state: &Self::State) -> Option<ServoParameters>;

    /// Joins a motion after a gap in the samples: the model restarts alongside the servo, the
    /// estimates and what is known of them are kept.
    fn join(&self, state: &mut Self::State);
}

/// What one sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Seen<N> {
    /// Output error ε = q − q_e, counts, before the update.
    pub output_error: N,
    /// What happened besides.
    pub event: Event,
}

/// What happened in a sample besides learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Event {
    /// Nothing.
    None,
    /// The law reduced its step, because the sample time would not bear it.
    Slowed,
    /// A fit was found good and the recursion starts from it.
    Started,
    /// The model could no longer explain the motion and starts again; estimates are kept until a
    /// new fit is found.
    Restarted,
    /// The load changed in a step; it is being sought, the other estimates stand meanwhile.
    LoadStep,
    /// The servo moves where the model's friction would hold it: the friction was lowered.
    FrictionLowered,
    /// The servo does not move as the command says (an amplifier that is off, a blocked axis).
    /// Nothing is learnt until it does.
    NotFollowing,
}

/// Refuses a sample that cannot be.
#[inline]
pub(super) fn check<N: Number>(increment: N, command: N, longest: N) -> Result<(), StepError> {
    // Nor is what the number format cannot compute with. What is not a number fails both comparisons.
    let possible = command.magnitude() <= N::REACH;
    if !possible {
        return Err(StepError::CommandNotFinite);
    }
    if increment.magnitude() <= longest {
        Ok(())
    } else {
        Err(StepError::CountJumped)
    }
}
