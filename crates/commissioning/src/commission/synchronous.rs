use super::{
    CommissionError, CommissionInputs, CommissionIsr, CommissionSettings, CommissionSolver,
    CommissionState, HoldingGains, Limits, Phase, TrialResult,
};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::Tuning;

/// Both halves of a commissioning in one place, for a servo that waits: one that is simulated.
///
/// A sample is that of [`CommissionIsr`], followed by its slices of the [`CommissionSolver`]. It is thus the same to
/// the bit wherever it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SynchronousCommission<N: Number, const W: usize = 256> {
    commission: CommissionIsr<N>,
    study: CommissionSolver<N, W>,
    settings: CommissionSettings,
    before: Option<HoldingGains>,
    held: Option<N>,
    state: Option<CommissionState<N>>,
    /// True if the gains were reported.
    is_tuned: bool,
}

/// Result of a sample of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CommissionReading {
    /// The command that acts until the next sample, command units; none: the stage is disabled.
    pub command: Option<f64>,
    /// Its phase.
    pub phase: Phase,
    /// Why it ended without new gains, if it did.
    pub reason: Option<Reason>,
    /// The servo, if the solver has improved its estimate in this sample.
    pub servo: Option<IdentifiedServo>,
    /// The gains, if they were found and not reported before.
    pub tuning: Option<Tuning>,
    /// Where a controller wants the servo, counts from where it began; none where none acts.
    pub setpoint: Option<f64>,
    /// The measurements of the trial, once the commissioning has ended.
    pub trial: Option<TrialResult>,
}

impl<N: Number, const W: usize> SynchronousCommission<N, W> {
    /// About to begin, held by these gains with this command, if by any.
    ///
    /// # Errors
    /// As [`CommissionIsr::new`] and [`CommissionSettings::check_held`].
    pub fn new(
        settings: &CommissionSettings,
        before: Option<&HoldingGains>,
        held: Option<f64>,
    ) -> Result<Self, CommissionError> {
        settings.check_held(held.unwrap_or(0.0))?;
        Ok(Self {
            commission: CommissionIsr::new(settings, before)?,
            study: CommissionSolver::new(settings)?,
            settings: *settings,
            before: before.copied(),
            held: held.map(N::from_f64),
            state: None,
            is_tuned: false,
        })
    }

    /// One sample. It begins with the first.
    pub fn sample(&mut self, seen: &CommissionInputs) -> CommissionReading {
        self.sample_with_slices(seen, self.slices())
    }

    /// The slices of work that the background should do in each sample.
    #[must_use]
    pub fn slices(&self) -> u32 {
        self.commission.slices()
    }

    /// One sample in which the background does this many slices of work. A faster background does more than its share,
    /// one with other work fewer.
    pub fn sample_with_slices(
        &mut self,
        seen: &CommissionInputs,
        slices: u32,
    ) -> CommissionReading {
        let reading = self.process(seen, slices);
        if reading.reason == Some(Reason::EncoderNoise)
            && let Some(again) = self.with_noise()
        {
            *self = again;
            return CommissionReading {
                phase: Phase::Rest,
                reason: None,
                ..reading
            };
        }
        reading
    }

    fn process(&mut self, seen: &CommissionInputs, slices: u32) -> CommissionReading {
        let Self {
            commission,
            study,
            held,
            state,
            is_tuned,
            ..
        } = self;
        let state = state.get_or_insert_with(|| commission.start(seen.count.unwrap_or(0), *held));
        let step = commission.process(state, seen);
        if let Some(finding) = &step.finding {
            study.take(finding);
        }
        let mut servo = None;
        for answer in (0..slices).filter_map(|_| study.work()) {
            servo = answer.servo().copied().or(servo);
            commission.accept(state, &answer);
        }
        let tuning = state.tuning().copied().filter(|_| !*is_tuned);
        *is_tuned |= tuning.is_some();
        CommissionReading {
            command: step.command.map(Number::to_f64),
            phase: step.phase,
            reason: state.reason(),
            servo,
            tuning,
            setpoint: state.setpoint().map(Number::to_f64),
            trial: state.trial().copied().filter(|_| step.phase.is_end()),
        }
    }

    /// The commissioning from the beginning with the encoder's noise at rest, which is more than declared. None if that
    /// leaves no room for a motion.
    fn with_noise(&self) -> Option<Self> {
        let state = self.state.as_ref()?;
        let noise = state.noise() * self.settings.resolution;
        let moved = state.moved() * self.settings.resolution;
        let limits = self.settings.limits;
        let settings = CommissionSettings {
            noise,
            limits: Limits {
                travel: limits.travel.map(|end| end - moved),
                ..limits
            },
            ..self.settings
        };
        let is_more = noise > CommissionIsr::<N>::MAX_NOISE_FACTOR * self.settings.noise;
        // A command of the noise's holds no load.
        let held = self.held.map(Number::to_f64);
        let again = || Self::new(&settings, self.before.as_ref(), held);
        is_more.then(again)?.ok()
    }

    /// Standard deviation of the encoder's noise, rad. It is the declared one, or a larger one at rest.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.settings.noise
    }

    /// Its solver, which has the frequency response that was measured.
    #[must_use]
    pub fn solver(&self) -> &CommissionSolver<N, W> {
        &self.study
    }

    /// Its progress; none before the first sample.
    #[must_use]
    pub fn state(&self) -> Option<&CommissionState<N>> {
        self.state.as_ref()
    }
}
