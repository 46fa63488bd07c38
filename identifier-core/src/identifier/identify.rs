use crate::error::StepError;
use crate::number::Arithmetic;
use crate::parameters::{PerParameter, ServoParameters, Terms, Unknown};
use crate::reason::Reason;

/// An identifier: it only listens. It gets two numbers per sample. One is the increment of the encoder since the last
/// sample, the other the command that acts until the next.
///
/// N is the number that it computes in: [`Number`](crate::number::Number), or a fixed-point word.
pub trait Identify<N: Copy> {
    /// The state between samples.
    type State: Clone + core::fmt::Debug;

    /// The estimates as it computes with them: a few words, which an interrupt copies and the
    /// background converts to SI.
    type Snapshot: Copy + core::fmt::Debug;

    /// The state at the start: the model at rest at the servo's position.
    fn start(&self) -> Self::State;

    /// Counts as the number that it computes in.
    fn increment(&self, moved: i32) -> N;

    /// Takes one sample. The counts `moved` are those since the last sample, through any wrap of the counter. The
    /// *total* `command` acts from this sample to the next, command units. It is limited, and includes feed-forward,
    /// dither and any other addition.
    ///
    /// # Errors
    /// [`StepError`] for an impossible input; the state is then untouched.
    #[inline]
    fn process(
        &self,
        state: &mut Self::State,
        moved: i32,
        command: N,
    ) -> Result<Update<N>, StepError> {
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
    ) -> Result<Update<N>, StepError> {
        self.check(increment, command)?;
        Ok(self.update(state, increment, command))
    }

    /// Checks that increment and command are finite and in range.
    ///
    /// # Errors
    /// [`StepError::CountJumped`], [`StepError::CommandNotFinite`].
    fn check(&self, increment: N, command: N) -> Result<(), StepError>;

    /// [`Identify::learn`] for inputs that were checked ([`Identify::check`]); the commands of our
    /// controller always pass. Other inputs can spoil the estimates, but nothing else.
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N>;

    /// The present estimates in the form in which the identifier computes.
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot;

    /// Estimates that were shown, SI.
    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters;

    /// Which of the estimates that were shown are at a bound: such a value is no result.
    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool>;

    /// True once there are estimates. An identifier that starts from initial values has them at once, one that starts
    /// by a fit after that fit.
    fn has_estimates(&self, _: &Self::State) -> bool {
        true
    }

    /// The estimates, SI; none before there are any.
    fn estimates(&self, state: &Self::State) -> Option<ServoParameters> {
        self.has_estimates(state)
            .then(|| self.estimates_in(&self.snapshot(state)))
    }

    /// Which estimates are at a bound.
    fn at_bounds(&self, state: &Self::State) -> PerParameter<bool> {
        self.at_bounds_in(&self.snapshot(state))
    }

    /// Their standard errors, SI, for estimators that have them. Zero for a parameter that the model lacks.
    fn standard_errors(&self, state: &Self::State) -> Option<ServoParameters> {
        let of = |unknown| self.standard_error_of(state, unknown);
        Some(ServoParameters {
            a: of(Unknown::A)?,
            b: of(Unknown::B)?,
            coulomb: of(Unknown::Coulomb).unwrap_or(0.0),
            load: of(Unknown::Load).unwrap_or(0.0),
        })
    }

    /// The estimate of an unknown that was shown, SI; none if the model does not have it. For a term
    /// that has not [entered](Identify::entered) it is its initial value.
    fn value_in(&self, shown: &Self::Snapshot, unknown: Unknown) -> Option<f64> {
        let parameter = unknown.parameter()?;
        Some(parameter.value_in(&self.estimates_in(shown)))
    }

    /// Its standard error, SI, for estimators that have it.
    fn standard_error_of(&self, _: &Self::State, _: Unknown) -> Option<f64> {
        None
    }

    /// The optional terms that are estimated by now.
    fn entered(&self, _: &Self::State) -> Terms {
        Terms::NONE
    }

    /// Why no first fit has succeeded after a second of motion, or after its record if that is longer. For estimators
    /// that begin by a fit. None before that time, and after a fit has succeeded.
    fn rejection_reason(&self, _: &Self::State) -> Option<Reason> {
        None
    }

    /// Standard deviation of the position's noise in motion, position units, for estimators that begin by a fit. The
    /// last accepted fit gives it. If it is not clearly more than in the settings, it is that of the settings, rounding
    /// alone.
    fn noise(&self, _: &Self::State) -> Option<f64> {
        None
    }

    /// Says at which position (position units) the servo is before the first sample, for models that
    /// depend on the angle.
    fn place(&self, _: &mut Self::State, _: N) {}

    /// Bandwidth of the model's correction, rad/s, where the identifier chooses it and may change it.
    fn bandwidth(&self, _: &Self::State) -> Option<f64> {
        None
    }

    /// Work in the background, at most `budget` steps of it: fits. Call it whenever there is time, on
    /// a PC after every sample; without work to do it returns at once.
    fn work(&self, _: &mut Self::State, _: u32) {}

    /// Joins a motion after a gap, before its next sample. The estimates are kept. The model restarts at the servo's
    /// position, moving by `increment` a sample.
    fn resume_moving(&self, state: &mut Self::State, increment: N);
}

/// The observation of the identifier in a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Update<N> {
    /// Output error ε = q − q_e before the update, position units.
    pub output_error: N,
    /// The event besides learning.
    pub event: Event,
}

/// The events of a sample besides learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Event {
    /// Nothing else.
    None,
    /// A guard shortened the estimator's step.
    Slowed,
    /// Nothing was learnt: the servo is at standstill.
    Standing,
    /// The model left the range of the number format and was restarted at the servo's position. The estimates are kept.
    Restarted,
    /// A first fit succeeded, and the recursion starts from it.
    Started,
    /// The load has changed by a step: it is estimated anew, and the other estimates are kept
    /// meanwhile.
    LoadStep,
    /// A term that is demanded has entered.
    TermEntered,
    /// The servo moves where the model's friction would hold it: the friction was lowered.
    FrictionLowered,
    /// The servo does not follow its command: amplifier off, or a limit that was not taken into the
    /// recorded command. Nothing is learnt.
    NotFollowing,
    /// No first fit has succeeded after a second of motion: [`Identify::rejection_reason`] has the reason.
    FirstFitOverdue,
}

/// Refuses an impossible sample.
#[inline]
pub(super) fn check<N: Arithmetic>(increment: N, command: N, longest: N) -> Result<(), StepError> {
    // NaN fails both comparisons.
    let moved_within = increment.magnitude() <= longest;
    if !moved_within {
        return Err(StepError::CountJumped);
    }
    // Beyond this the number format overflows.
    let possible = command.magnitude() <= N::REACH;
    if possible {
        Ok(())
    } else {
        Err(StepError::CommandNotFinite)
    }
}
