use super::{Candidate, Identified, IdentifiedServo, MotionBlock, Phase, Reason};
use crate::number::Number;
use crate::tuning::TuningError;

/// What the interrupt's half tells the study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RecordEvent<N> {
    /// A motion of this phase begins: [`Phase::Probing`], [`Phase::Refine`] or [`Phase::Verify`].
    Begins(Phase),
    /// A piece of its record.
    Block(MotionBlock<N>),
    /// It has ended and was recorded: study it.
    Ended,
}

/// What the study answers, once for each motion that has ended, and once more when it has tuned.
///
/// All that the interrupt's half needs is prepared in it: no sample converts from SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decision<N: Number> {
    /// The servo as it is known now: after the first motion and after the second.
    Identified(Identified<N>),
    /// The servo as it is known after a motion, not well enough: the second is done again.
    Uncertain(Identified<N>),
    /// The third motion was predicted; gains are looked for next.
    Verified,
    /// Gains and what they promise.
    Tuned(Candidate<N>),
    /// No gains keep what was asked for; which would do is in the error.
    NoGains(TuningError),
    /// An effect that the model lacks of the servo: what goes wrong from now on may come of it; none if what
    /// was suspected before is explained. Another answer follows.
    Suspects(Option<Reason>),
    /// It cannot go on.
    Failed(Reason),
}

impl<N: Number> Decision<N> {
    /// The servo, where the answer tells of one.
    #[must_use]
    pub fn servo(&self) -> Option<&IdentifiedServo> {
        match self {
            Self::Identified(known) | Self::Uncertain(known) => Some(&known.servo),
            _ => None,
        }
    }
}
