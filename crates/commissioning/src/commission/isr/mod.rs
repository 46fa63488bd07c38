mod monitoring;
mod sequence;

use super::conservative_pid::ConservativePid;
use super::gains::{HoldingGains, Loop};
use super::governor::Governor;
use super::message::DecisionKind;
use super::noise::Hysteresis;
use super::standing::StandingTest;
use super::state::{Activity, CommissionState, Next};
use super::{
    CommissionError, CommissionSettings, Decision, LargestMotion, Phase, Probing, RecordEvent,
};
use crate::watch::{Observation, ServoWatch};
use identifier_core::control::ControlSample;
use identifier_core::fit::Blocking;
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::units::Units;

/// The interrupt's half of a commissioning. It moves the servo, checks it for faults and never waits.
///
/// In each sample the caller calls [`CommissionIsr::control`], outputs its command at once, and calls
/// [`CommissionIsr::learn`]. It passes the [`RecordEvent`] to the [`CommissionSolver`](super::CommissionSolver),
/// which does [`CommissionIsr::slices`] slices of work. It passes the solver's [`Decision`] to
/// [`CommissionIsr::accept`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionIsr<N: Number> {
    settings: CommissionSettings,
    hysteresis: Hysteresis<N>,
    /// The blocks of the recorded motions.
    blocking: Blocking<N>,
    /// Noise at rest up to which the commissioning continues, counts.
    tolerated_noise: N,
    units: Units,
    pub(in crate::commission) probing: Probing<N>,
    pub(in crate::commission) watch: ServoWatch<N>,
    standing: StandingTest<N>,
    before: Option<Loop<N>>,
    conservative: ConservativePid<N>,
    limit: [N; 2],
    /// Counts a sample, at which the servo is brought to a place.
    pace: N,
    /// Samples of a rest, and that the solver may take.
    rest: u32,
    patience: u32,
    /// Delay of the commands before the servo is identified, samples.
    delay: N,
    /// The command by which that of a rest may differ from the load's besides what friction explains.
    spare: N,
    governor: Governor<N>,
}

/// Inputs of a commissioning in a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommissionInputs {
    /// The encoder's count, which wraps at 32 bits; none if it gave no valid reading.
    pub count: Option<i32>,
    /// True if the sample before ended too late.
    pub late: bool,
    /// A reason for which the caller ends it. After its end too, one that disables the stage does so.
    pub stop: Option<Reason>,
}

/// Outputs of a commissioning in a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionStep<N> {
    /// The command that is to act until the next; none: disable the stage.
    pub command: Option<N>,
    /// The present phase.
    pub phase: Phase,
    /// The event for the solver.
    pub finding: Option<RecordEvent<N>>,
}

impl<N: Number> CommissionIsr<N> {
    /// Time for which a servo must be still to be at rest, s, and samples.
    pub const REST: (f64, f64) = (0.02, 8.0);

    /// The longest that the solver may take, or a servo may need to come to rest, s.
    pub const PATIENCE: f64 = 30.0;

    /// The part of the largest speed at which a servo is brought to a place.
    pub const PACE: f64 = 0.2;

    /// Time assumed for a slice of the solver, s. On a Cortex-M4F at 168 MHz the mean slice takes half of it. A few
    /// that end a fit or begin a search take longer than all of it (`commission-slice` in the firmware's budget).
    const SLICE: f64 = 5e-5;

    /// Delay beyond the declared one that a command may have before the servo is identified, samples.
    const UNKNOWN_DELAY: f64 = 2.0;

    /// The part of the command by which that of a rest may differ from the load's besides what friction explains.
    const SPARE: f64 = 0.05;

    /// Noise at rest that motion is not mistaken for, counts, and the part by which it may exceed the declared one.
    const TOLERATED_NOISE: f64 = 0.5;
    pub(in crate::commission) const MAX_NOISE_FACTOR: f64 = 1.5;

    /// For an axis that is disabled, or held by the old gains.
    ///
    /// # Errors
    /// The setting that is contradictory or impossible within the limits, with a value that would fit.
    pub fn new(
        settings: &CommissionSettings,
        before: Option<&HoldingGains>,
    ) -> Result<Self, CommissionError> {
        settings.check()?;
        let hysteresis = Hysteresis::new(settings.noise / settings.resolution);
        let tolerated_noise = Self::tolerated_noise(settings);
        let settings = &settings.in_units_of_noise();
        let limits = &settings.limits;
        let units = Units::new(settings.sample_time, settings.resolution)?;
        let samples = |time: f64| time / settings.sample_time;
        let [low, high] = limits.command;
        let speed = limits.speed * units.velocity();
        let (rest, fewest) = Self::REST;
        let delay = samples(settings.command_delay) + Self::UNKNOWN_DELAY;
        Ok(Self {
            settings: *settings,
            hysteresis,
            blocking: settings.blocking(),
            tolerated_noise,
            probing: Probing::new(settings)?,
            watch: ServoWatch::new(&settings.watch())?,
            standing: StandingTest::new(
                high.max(-low),
                limits.travel.map(|end| end / settings.resolution),
                settings.sample_time,
                delay,
            ),
            before: before.map(|gains| gains.build(&units)).transpose()?,
            conservative: ConservativePid::new(&units, limits),
            limit: [N::from_f64(low), N::from_f64(high)],
            pace: N::from_f64(Self::PACE * speed),
            // Casts saturate.
            rest: samples(rest).max(fewest) as u32,
            patience: samples(Self::PATIENCE) as u32,
            delay: N::from_f64(delay),
            spare: N::from_f64(Self::SPARE * high.min(-low)),
            governor: Governor::new(&units, limits, settings.max_gain, delay),
            units,
        })
    }

    fn tolerated_noise(settings: &CommissionSettings) -> N {
        let declared = Self::MAX_NOISE_FACTOR * settings.noise / settings.resolution;
        N::from_f64(declared.max(Self::TOLERATED_NOISE))
    }

    /// The largest motion that is possible before the servo is identified.
    #[must_use]
    pub fn largest_motion(&self) -> LargestMotion {
        self.settings.largest_motion()
    }

    /// The slices of work that the solver does in each sample.
    #[must_use]
    pub fn slices(&self) -> u32 {
        ((self.settings.sample_time / Self::SLICE) as u32).clamp(1, 32)
    }

    /// Begins at the servo's position. `held` is the command with which the old gains hold it now.
    #[must_use]
    pub fn start(&self, count: i32, held: Option<N>) -> CommissionState<N> {
        let command = held.unwrap_or(N::ZERO);
        let activity = match self.before {
            Some(before) => Activity::Holding(self.held_by(before, N::ZERO, N::ZERO, command)),
            None => Activity::Free,
        };
        let watch = self
            .watch
            .start_delayed(self.settings.command_delay / self.settings.sample_time);
        let bandwidth = self.conservative.max_bandwidth();
        CommissionState::begun(count, command, activity, watch, self.hysteresis, bandwidth)
    }

    /// Takes over from a controller with the old gains that ran up to a count. `last` is its last sample. Its command
    /// continues without a step, its integral is carried over, and its reference is set to the servo's position. For
    /// a state of [`CommissionIsr::start`] that has run no sample yet, where there is no time to build a new one.
    pub fn take_over(&self, state: &mut CommissionState<N>, count: i32, last: &ControlSample<N>) {
        state.begin_at(count);
        let last = &last.scaled(|counts| self.hysteresis.in_units(counts));
        let Some(before) = self.before else {
            return;
        };
        let [low, high] = self.limit;
        let moving = before.linear(last.error, last.velocity);
        state.held = (last.command - moving).limited(low, high);
        state.command = last.command;
        state.governed.set_speed(last.velocity);
        let mut holding = self.held_after(before, N::ZERO, last);
        holding.send(N::ZERO);
        state.activity = Activity::Holding(holding);
    }

    /// One sample, [`CommissionIsr::control`] and [`CommissionIsr::learn`], for a servo that waits meanwhile.
    pub fn process(
        &self,
        state: &mut CommissionState<N>,
        inputs: &CommissionInputs,
    ) -> CommissionStep<N> {
        let _ = self.control(state, inputs);
        self.learn(state)
    }

    /// The first part of a sample: the command that is to act at once; none: disable the stage. After an end it
    /// continues to hold the servo, with the new gains or those before, or keeps the stage disabled.
    pub fn control(&self, state: &mut CommissionState<N>, inputs: &CommissionInputs) -> Option<N> {
        state.observation = Observation {
            // Of the servo as the command before has left it, while the activity is that which gave it.
            increment: state.follow(inputs.count),
            command: state.command,
            position: state.position,
            setpoint: state.activity.setpoint(),
            late: inputs.late,
            must_move: state.activity.must_move(),
            excited: state.response_motion.injects(),
        };
        let increment = state.observation.increment;
        (self.governor).follow(
            &mut state.governed,
            increment.unwrap_or(N::ZERO),
            state.command,
        );
        let is_end = state.phase.is_end();
        // For as long as anything drives the servo.
        state.was_end = is_end;
        state.is_watched = !is_end || !matches!(state.activity, Activity::Free);
        match inputs.stop {
            Some(reason) if !is_end => {
                self.end(state, reason);
                state.is_watched = false;
            }
            Some(reason) if reason.disables_stage() => state.activity = Activity::Free,
            _ => {}
        }
        let is_end = state.phase.is_end();
        self.govern(state);
        state.acting = match increment {
            Some(increment) => self.command(state, increment),
            // A reading that is missing alone is bridged.
            None => Some(state.command).filter(|_| !is_end),
        };
        state.command = state.acting.unwrap_or(N::ZERO);
        state.acting
    }

    /// Confines the commands of this sample to those that keep the servo within its limits, in every phase but the trial
    /// and after the end.
    fn govern(&self, state: &mut CommissionState<N>) {
        let servo = match &state.activity {
            Activity::Probing(probing) => probing.servo(),
            Activity::ResponseWindows(_) => state.response_motion.loop_plan().0,
            _ => &state.rough,
        };
        let known = servo.is_known().then_some([servo.gain, servo.per_gain]);
        let governed = &mut state.governed;
        let allowed = if state.phase.is_end() || state.phase == Phase::Trial {
            self.governor.allow_all(governed)
        } else {
            (self.governor).allow(governed, known, state.position, state.command)
        };
        state.activity.allow(allowed);
    }

    /// The second part of a sample, while the command acts. It checks the servo, records its motion and decides the
    /// action of the next sample. The command differs from that of [`CommissionIsr::control`] where the commissioning
    /// ends in this sample: then it takes the place of that one.
    pub fn learn(&self, state: &mut CommissionState<N>) -> CommissionStep<N> {
        let increment = state.observation.increment;
        let decided = self.monitored(state).and_then(|()| self.proceed(state));
        if let Err(reason) = decided {
            if self.is_back(state) {
                // The gains before fail too, and that is why nothing holds it.
                state.activity = Activity::Free;
                state.reason = Some(reason);
            } else if !self.suspected_reason(state, reason) {
                self.end(state, reason);
            }
            state.acting = increment.and_then(|_| self.command(state, N::ZERO));
            state.command = state.acting.unwrap_or(N::ZERO);
        }
        if let Some(trial) = state.measured.take() {
            let result = trial.result(&self.units);
            // The prediction takes the measured rise of a loop that is slower.
            if let (Some(candidate), Some(rise)) = (&mut state.candidate, result.rise_time) {
                let predicted = &mut candidate.tuning.predicted_response.rise_time;
                *predicted = predicted.max(rise);
            }
            state.trial = Some(result);
        }
        state.record(&self.blocking, increment.unwrap_or(N::ZERO));
        CommissionStep {
            command: state.acting,
            phase: state.phase,
            finding: state.finding(),
        }
    }

    /// Takes an answer of the solver.
    pub fn accept(&self, state: &mut CommissionState<N>, answer: &Decision<N>) {
        if state.phase.is_end() || state.suspected_fault().is_some() {
            return;
        }
        state.next = match &answer.0 {
            DecisionKind::Identified(known) => {
                state.identified = Some(*known);
                return;
            }
            DecisionKind::ResponseMotion(plan) => {
                state.response_motion.plan(plan);
                Next::ResponseMotion
            }
            DecisionKind::Verified(known) => {
                state.identified = Some(*known);
                Next::Tune
            }
            DecisionKind::Tuned(candidate) => {
                let start = candidate.trial.start();
                if start != N::ZERO
                    && let Activity::Holding(holding) = &mut state.activity
                {
                    holding.send(start);
                }
                state.candidate = Some(*candidate);
                Next::Trial
            }
            DecisionKind::Failed(reason, error) => {
                state.tuning_error = *error;
                Next::End(*reason)
            }
        };
    }
}
