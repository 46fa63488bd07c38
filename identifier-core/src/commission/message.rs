use super::{IdentifiedServo, MotionBlock, Phase, StopReason};
use crate::tuning::{Tuning, TuningError};

/// What the interrupt's half tells the study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding<N> {
    /// A motion of this phase begins: [`Phase::Wiggle`], [`Phase::Refine`] or [`Phase::Verify`].
    Begins(Phase),
    /// A piece of its record.
    Block(MotionBlock<N>),
    /// It has ended and was recorded: study it.
    Ended,
}

/// What the study answers, once for each motion that has ended, and once more when it has tuned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// The servo as it is known now: after the first motion and after the second.
    Identified(IdentifiedServo),
    /// The servo as it is known after a motion, not well enough: the second is done again.
    Uncertain(IdentifiedServo),
    /// The third motion was predicted; gains are looked for next.
    Verified,
    /// Gains and what they promise.
    Tuned(Tuning),
    /// No gains keep what was asked for; which would do is in the error.
    NoGains(TuningError),
    /// It cannot go on.
    Failed(StopReason),
}
