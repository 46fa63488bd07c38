use crate::control::ControlSample;
use crate::error::StepError;
use crate::model::ServoParameters;
use crate::number::Number;
use crate::settings::PerParameter;

/// An identifier: it only listens. Two numbers a sample are all it is told, how far the encoder moved
/// since the last sample and the command that acts from now until the next.
///
/// N is the number that it computes in: [`Number`](crate::number::Number), or a fixed-point word.
pub trait Identify<N: Copy> {
    /// What it remembers between samples.
    type State: Clone + core::fmt::Debug;

    /// The estimates as it computes with them: a few words, which an interrupt copies and the
    /// background makes SI of.
    type Shown: Copy + core::fmt::Debug;

    /// The state at the start: the model at rest where the servo is.
    fn start(&self) -> Self::State;

    /// Counts as the number that it computes in.
    fn increment(&self, moved: i32) -> N;

    /// One sample: the counts moved since the last sample, through any wrap of the counter, and the
    /// *total* command that acts from this sample to the next, command units: limited, with
    /// feed-forward, dither and whatever else is added to it.
    ///
    /// # Errors
    /// What cannot be; the state is then untouched.
    #[inline]
    fn process(
        &self,
        state: &mut Self::State,
        moved: i32,
        command: N,
    ) -> Result<Seen<N>, StepError> {
        self.learn(state, self.increment(moved), command)
    }

    /// The same for a sensor that does not count: the increment in position units.
    ///
    /// # Errors
    /// As [`Identify::process`].
    #[inline]
    fn learn(
        &self,
        state: &mut Self::State,
        increment: N,
        command: N,
    ) -> Result<Seen<N>, StepError> {
        self.check(increment, command)?;
        Ok(self.follow(state, increment, command))
    }

    /// Whether increment and command can be.
    ///
    /// # Errors
    /// [`StepError::CountJumped`], [`StepError::CommandNotFinite`].
    fn check(&self, increment: N, command: N) -> Result<(), StepError>;

    /// [`Identify::learn`] for what was checked: a controller of ours gives no other commands. Anything
    /// else does no harm but to the estimates.
    fn follow(&self, state: &mut Self::State, increment: N, command: N) -> Seen<N>;

    /// The same beside a controller of ours, whose velocity estimate need not be made twice.
    #[inline]
    fn follow_beside(&self, state: &mut Self::State, sample: &ControlSample<N>) -> Seen<N> {
        self.follow(state, sample.increment, sample.command)
    }

    /// The estimates of the moment, as they are.
    fn show(&self, state: &Self::State) -> Self::Shown;

    /// Estimates that were shown, SI.
    fn estimates_of(&self, shown: &Self::Shown) -> ServoParameters;

    /// Which of the estimates that were shown stand at a bound: such a value is no result.
    fn at_bounds_of(&self, shown: &Self::Shown) -> PerParameter<bool>;

    /// The estimates, SI.
    fn estimates(&self, state: &Self::State) -> ServoParameters {
        self.estimates_of(&self.show(state))
    }

    /// Which estimates stand at a bound.
    fn at_bounds(&self, state: &Self::State) -> PerParameter<bool> {
        self.at_bounds_of(&self.show(state))
    }

    /// Their standard errors, SI, for laws that have them.
    fn standard_errors(&self, _: &Self::State) -> Option<ServoParameters> {
        None
    }

    /// Bandwidth of the model's correction, rad/s, where it is the identifier's own and may change.
    fn bandwidth(&self, _: &Self::State) -> Option<f64> {
        None
    }

    /// Work in the background, at most `budget` steps of it: fits. Call it whenever there is time, on a
    /// PC after every sample; what there is nothing to do for returns at once.
    fn work(&self, _: &mut Self::State, _: u32) {}

    /// Joins a motion after a gap, before its next sample: what was learnt is kept, the model starts
    /// again beside the servo, moving by `increment` a sample.
    fn join(&self, state: &mut Self::State, increment: N);
}

/// What a sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Seen<N> {
    /// Output error ε = q − q_e before the update, position units.
    pub output_error: N,
    /// What happened besides.
    pub event: Event,
}

/// What happened in a sample besides learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Event {
    /// Nothing else.
    None,
    /// A guard shortened the law's step.
    Slowed,
    /// Nothing was learnt: the servo stays where it is.
    Standing,
    /// The model had run out of the number format's reach and starts again where the servo is; the
    /// estimates are kept.
    Restarted,
    /// A first fit was found good, and the recursion starts from it.
    Started,
    /// The load has changed by a step: it is being sought, and the other estimates stand meanwhile.
    LoadStep,
    /// The servo moves where the model's friction would hold it: the friction was lowered.
    FrictionLowered,
    /// The servo does not follow its command: amplifier off, or a limit that was not taken into the
    /// recorded command. Nothing is learnt.
    NotFollowing,
}

/// Refuses a sample that cannot be.
#[inline]
pub(super) fn check<N: Number>(increment: N, command: N, longest: N) -> Result<(), StepError> {
    // What is not a number fails both comparisons.
    let moved_within = increment.magnitude() <= longest;
    if !moved_within {
        return Err(StepError::CountJumped);
    }
    // Nor is what the number format cannot compute with.
    let possible = command.magnitude() <= N::REACH;
    if possible {
        Ok(())
    } else {
        Err(StepError::CommandNotFinite)
    }
}
