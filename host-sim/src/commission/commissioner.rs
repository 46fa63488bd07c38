//! What commissions a servo, here or on a chip.

use identifier_core::commission::{
    Answer, Commission, CommissionError, CommissionSettings, CommissionState, HoldingGains,
    IdentifiedServo, Phase, Seen, StopReason, Study, TrialResult,
};
use identifier_core::number::Number;
use identifier_core::tuning::Tuning;

use super::RECORD;

/// Both halves of a commissioning, one sample after the other.
pub trait Commissioner {
    /// Why it does no further sample.
    type Error;

    /// A sample: what the interrupt's half does, and after it the slices of the study that go with it.
    ///
    /// # Errors
    /// Why it is not done.
    fn sample(&mut self, seen: &Seen) -> Result<Done, Self::Error>;
}

/// What was done in a sample, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Done {
    /// The command that acts until the next, command units; none: the servo is let go.
    pub command: Option<f64>,
    /// Where the commissioning stands.
    pub phase: Phase,
    /// Why it ended without new gains, if it did.
    pub reason: Option<StopReason>,
    /// The servo, if it is known better since this sample.
    pub servo: Option<IdentifiedServo>,
    /// The gains, if they were found and not told before.
    pub tuning: Option<Tuning>,
    /// Where a controller wants the servo, counts from where it began; none where none acts.
    pub setpoint: Option<f64>,
    /// What the trial has measured, once the commissioning has ended.
    pub trial: Option<TrialResult>,
}

/// The firmware's machine, here.
#[derive(Debug)]
pub(super) struct Here<N: Number> {
    machine: Commission<N>,
    study: Study<N, RECORD>,
    held: Option<N>,
    state: Option<CommissionState<N>>,
    is_tuned: bool,
}

impl<N: Number> Here<N> {
    /// About to begin, held by gains with a command, if by any.
    pub(super) fn new(
        settings: &CommissionSettings,
        before: Option<&HoldingGains>,
        held: Option<f64>,
    ) -> Result<Self, CommissionError> {
        Ok(Self {
            machine: Commission::new(settings, before)?,
            study: Study::new(settings)?,
            held: held.map(N::from_f64),
            state: None,
            is_tuned: false,
        })
    }
}

impl<N: Number> Commissioner for Here<N> {
    type Error = std::convert::Infallible;

    fn sample(&mut self, seen: &Seen) -> Result<Done, Self::Error> {
        let Self {
            machine,
            study,
            held,
            state,
            is_tuned,
        } = self;
        let state = state.get_or_insert_with(|| machine.start(seen.count.unwrap_or(0), *held));
        let step = machine.process(state, seen);
        if let Some(finding) = &step.finding {
            study.take(finding);
        }
        let mut servo = None;
        for answer in (0..machine.slices()).filter_map(|_| study.work()) {
            if let Answer::Identified(found) | Answer::Uncertain(found) = answer {
                servo = Some(found);
            }
            machine.accept(state, &answer);
        }
        let tuning = state.tuning().copied().filter(|_| !*is_tuned);
        *is_tuned |= tuning.is_some();
        Ok(Done {
            command: step.command.map(Number::to_f64),
            phase: step.phase,
            reason: state.reason(),
            servo,
            tuning,
            setpoint: state.setpoint().map(Number::to_f64),
            trial: state.trial().copied().filter(|_| step.phase.is_end()),
        })
    }
}
