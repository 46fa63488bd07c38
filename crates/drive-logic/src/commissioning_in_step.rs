//! A commissioning on the chip, its servo elsewhere: both halves in one sample, as in the simulator.

use drive_link::{CommissionReading, NotAllowed};
use identifier_core::commission::{
    Answer, Commission, CommissionSettings, CommissionState, HoldingGains, Seen,
};

use crate::parts;
use crate::studying::Study;

/// Both halves of a commissioning.
#[derive(Debug)]
pub(crate) struct CommissioningInStep {
    commission: Commission<f32>,
    study: Study,
    held: Option<f32>,
    state: Option<CommissionState<f32>>,
    /// The gains were told.
    is_tuned: bool,
}

impl CommissioningInStep {
    /// About to begin, held by these gains with this command, if by any.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(
        settings: &CommissionSettings,
        before: Option<&HoldingGains>,
        held: Option<f64>,
    ) -> Result<Self, NotAllowed> {
        let refused = |error| parts::not_commissioned(&error);
        Ok(Self {
            commission: Commission::new(settings, before).map_err(refused)?,
            study: Study::new(settings).map_err(refused)?,
            held: held.map(|held| held as f32),
            state: None,
            is_tuned: false,
        })
    }

    /// One sample, with the slices of the study that go with it.
    pub(crate) fn sample(&mut self, seen: &Seen) -> CommissionReading {
        let Self {
            commission,
            study,
            held,
            state,
            is_tuned,
        } = self;
        let state = state.get_or_insert_with(|| commission.start(seen.count.unwrap_or(0), *held));
        let step = commission.process(state, seen);
        if let Some(finding) = &step.finding {
            study.take(finding);
        }
        let mut servo = None;
        for _ in 0..commission.slices() {
            let Some(answer) = study.work() else {
                continue;
            };
            if let Answer::Identified(found) | Answer::Uncertain(found) = answer {
                servo = Some(found);
            }
            commission.accept(state, &answer);
        }
        let tuning = state.tuning().copied().filter(|_| !*is_tuned);
        *is_tuned |= tuning.is_some();
        CommissionReading {
            command: step.command.map(f64::from),
            phase: step.phase,
            reason: state.reason(),
            servo,
            tuning,
            setpoint: state.setpoint().map(f64::from),
            trial: state.trial().copied().filter(|_| step.phase.is_end()),
        }
    }
}
