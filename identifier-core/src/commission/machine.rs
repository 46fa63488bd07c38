use super::{
    Answer, CommissionError, CommissionSettings, Finding, IdentifiedServo, LargestMotion, Phase,
    StopReason,
};
use crate::number::Number;
use crate::settings::ControllerSettings;
use crate::tuning::Tuning;

/// The interrupt's half of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Commission<N> {
    settings: CommissionSettings,
    number: core::marker::PhantomData<N>,
}

/// Gains that hold the servo before a commissioning, and again after one that failed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GainsBefore {
    /// The PID.
    pub controller: ControllerSettings,
    /// The cut-off of its velocity estimate, rad/s.
    pub cutoff: f64,
}

/// What a commissioning sees in a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seen {
    /// The encoder's count, which wraps at 32 bits; none if it gave no valid reading.
    pub count: Option<i32>,
    /// Whether the sample before ended too late.
    pub late: bool,
    /// What somebody else wants it to end for.
    pub stop: Option<StopReason>,
}

/// What it does in a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionStep<N> {
    /// The command that is to act until the next; none: let the servo go.
    pub command: Option<N>,
    /// Where the commissioning stands.
    pub phase: Phase,
    /// What the study is to be told.
    pub finding: Option<Finding<N>>,
}

/// A commissioning under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionState<N> {
    phase: Phase,
    reason: Option<StopReason>,
    servo: Option<IdentifiedServo>,
    tuning: Option<Tuning>,
    number: core::marker::PhantomData<N>,
}

impl<N: Number> Commission<N> {
    /// For an axis that stands let go, or is held by the gains before.
    ///
    /// # Errors
    /// What contradicts itself, or cannot be within the limits, with the figure that would do.
    pub fn new(
        settings: &CommissionSettings,
        _before: Option<&GainsBefore>,
    ) -> Result<Self, CommissionError> {
        settings.limits.check()?;
        Ok(Self {
            settings: *settings,
            number: core::marker::PhantomData,
        })
    }

    /// The largest motion that there can be before anything is known of the servo.
    #[must_use]
    pub fn largest_motion(&self) -> LargestMotion {
        LargestMotion {
            travel: self.settings.limits.travel,
            speed: self.settings.limits.speed,
        }
    }

    /// Begins where the servo stands. `held` is the command that holds it now.
    #[must_use]
    pub fn start(&self, _count: i32, _held: Option<N>) -> CommissionState<N> {
        CommissionState {
            phase: Phase::ReleasedCheck,
            reason: None,
            servo: None,
            tuning: None,
            number: core::marker::PhantomData,
        }
    }

    /// One sample. After an end it goes on holding the servo, with the new gains or those before, or
    /// keeps it let go.
    pub fn process(&self, state: &mut CommissionState<N>, seen: &Seen) -> CommissionStep<N> {
        state.phase = Phase::Aborted;
        state.reason = seen.stop.or(Some(StopReason::DoesNotMove));
        CommissionStep {
            command: None,
            phase: state.phase,
            finding: None,
        }
    }

    /// Takes an answer of the study.
    pub fn accept(&self, _state: &mut CommissionState<N>, _answer: &Answer) {}
}

impl<N: Number> CommissionState<N> {
    /// Where it stands.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Why it ended without new gains, if it did.
    #[must_use]
    pub fn reason(&self) -> Option<StopReason> {
        self.reason
    }

    /// The servo, as far as it is known.
    #[must_use]
    pub fn servo(&self) -> Option<&IdentifiedServo> {
        self.servo.as_ref()
    }

    /// The gains that were found, on trial or applied, and their promise.
    #[must_use]
    pub fn tuning(&self) -> Option<&Tuning> {
        self.tuning.as_ref()
    }
}
