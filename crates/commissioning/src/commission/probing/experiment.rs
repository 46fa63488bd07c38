use super::super::conservative_pid::ConservativePid;
use super::super::noise::has_missed;
use super::super::regression::Regression;
use super::super::{CommissionError, CommissionSettings};
use super::observer::{Observer, ObserverState};
use super::plan::Plan;
use super::state::{FreeMotion, ProbingStage, ProbingState};
use identifier_core::number::Number;
use identifier_core::reason::Reason;

/// Counts that a disabled servo at standstill may move.
const STANDS_WITHIN: f64 = 3.0;

/// The probing motion, in the sample interrupt: it takes the encoder's increment and gives a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Probing<N> {
    pub(super) plan: Plan<N>,
    pub(super) observer: Observer<N>,
    pub(super) regression: Regression<N>,
}

impl<N: Number> Probing<N> {
    /// # Errors
    /// See [`CommissionSettings::check_motion`].
    pub(crate) fn new(settings: &CommissionSettings) -> Result<Self, CommissionError> {
        settings.check_motion()?;
        let time = settings.sample_time;
        let limits = &settings.limits;
        // As fast as rounding lets it be: its acceleration must stay below that of a half-cycle.
        let [low, high] = limits.travel;
        let half_cycle = limits.speed * limits.speed / (high - low);
        let omega = libm::sqrt(2.0 * half_cycle / settings.resolution).min(0.8 / time);
        // Errors are independent of each other once counts have passed.
        let independent = (3.0 * settings.resolution / limits.speed).max(0.0005);
        let stride = libm::round(independent / time) as u32;
        Ok(Self {
            plan: Plan::new(settings),
            observer: Observer::new(omega.min(1200.0) * time),
            regression: Regression::new((80.0 * time).min(0.3), stride),
        })
    }

    /// Begins from rest; `held` is the command that a controller holds it with now.
    #[must_use]
    pub(crate) fn start(&self, held: Option<N>) -> ProbingState<N> {
        ProbingState::new(&self.plan, held)
    }

    /// Begins with a servo that was disabled for some samples, this one included. It is `position` counts from its
    /// start. None as long as it may still fall. If it falls so fast that it would soon reach a limit, the ramp opposes
    /// it immediately.
    #[must_use]
    pub(crate) fn start_released(&self, position: N, samples: u32) -> Option<ProbingState<N>> {
        if position.magnitude() <= N::from_f64(STANDS_WITHIN) {
            return (samples > self.plan.released).then(|| self.start(None));
        }
        let free_motion = FreeMotion::released(samples.saturating_sub(1));
        let observed = ObserverState::falling(position, free_motion.time);
        let mut state = ProbingState {
            position,
            extreme: position,
            origin: position,
            ..ProbingState::new(&self.plan, None)
        };
        let plan = &self.plan;
        let speed = observed.acceleration.magnitude() * plan.soon;
        if speed > plan.usable_speed || N::from_f64(0.5) * speed * plan.soon > plan.half_room {
            let direction = if position > N::ZERO { N::ONE } else { -N::ONE };
            state.direction = -direction;
            state.motion_direction = direction;
            state.origin = N::ZERO;
            state.free_motion = free_motion;
            state.observed = observed;
        }
        Some(state)
    }

    /// The command of a sample: the counts that the encoder has moved since the last.
    pub(crate) fn control(&self, state: &mut ProbingState<N>, increment: N) -> N {
        let plan = &self.plan;
        state.samples = state.samples.saturating_add(1);
        state.position += increment;
        state.still = if increment == N::ZERO {
            state.still.saturating_add(1)
        } else {
            0
        };
        if increment != N::ZERO {
            let motion_direction = if increment > N::ZERO { N::ONE } else { -N::ONE };
            state.move_on(motion_direction, plan.hold_half_cycle);
        }
        if state.direction * (state.position - state.extreme) > N::ZERO {
            state.extreme = state.position;
        }
        self.observe(state, increment);
        if let Some(reason) = self.left(state) {
            state.ending = Some(Err(reason));
            if !matches!(state.stage, ProbingStage::Stop | ProbingStage::Hold) {
                state.enter(ProbingStage::Stop);
            }
        }
        let wanted = match state.stage {
            ProbingStage::Seek => self.seek(state),
            ProbingStage::Push | ProbingStage::Brake | ProbingStage::Stop => self.half_cycle(state),
            ProbingStage::Hold => self.hold(state),
        };
        let [least, most] = plan.command;
        state.at_limit = if wanted >= most || wanted <= least {
            state.at_limit.saturating_add(1)
        } else {
            0
        };
        let command = state.confined(wanted);
        state.give(command);
        command
    }

    /// Ends a relay that excites a resonance. The motor alone has a multiple of the gain. It oscillates faster and
    /// harder than the relay moves it. A servo that falls by its load is not left to friction.
    fn end_ringing(&self, state: &mut ProbingState<N>) {
        /// Half-cycles after which it ends, and the multiple of the planned acceleration that they took.
        const HALF_CYCLES: u32 = 2;
        const HARDER: f64 = 2.4;
        let [speed, bandwidth] = self.plan.ringing;
        if let Some(half_cycle) = state.half_cycles.take(state.position) {
            let acceleration = N::from_f64(HARDER) * state.acceleration;
            let rings =
                half_cycle.is_faster(speed, bandwidth) && half_cycle.is_harder(acceleration);
            state.ringing += u32::from(rings);
        }
        if state.ringing >= HALF_CYCLES {
            state.ending = Some(Err(Reason::Oscillating));
            state.held_at = state.position;
            state.held_by = N::from_f64(ConservativePid::<N>::REDUCED_BANDWIDTH);
            state.enter(ProbingStage::Hold);
        }
    }

    /// Follows the motion of a sample with the model so far.
    fn observe(&self, state: &mut ProbingState<N>, increment: N) {
        let plan = &self.plan;
        let acted = state.given(plan.delay);
        self.observer
            .observe(&mut state.observed, &state.servo, increment, acted);
        // One that moves as fast as it is thought to would have passed counts.
        let has_missed = state.still > 1 && has_missed(state.observed.velocity, state.still);
        state.stands = state.still > plan.standing || has_missed;
        if state.stands {
            state.observed.stand();
        } else if state.motion_direction * state.observed.velocity < N::ZERO && increment != N::ZERO
        {
            state.observed.turn();
        }
    }

    /// Learns from a sample after its command, for the next. Returns its end, with the servo held at rest: with evidence,
    /// or without. The servo may then also be one that cannot be brought to rest.
    pub(crate) fn learn(
        &self,
        state: &mut ProbingState<N>,
        increment: N,
    ) -> Option<Result<(), Reason>> {
        if let Some(guess) = state.pending_estimate.take() {
            self.begin_regression(state, &guess);
        }
        self.regress(state, increment);
        self.stand(state);
        if state.is_oscillating() && state.broke_away.is_some() && state.ending.is_none() {
            self.end_ringing(state);
        }
        self.progress(state)
    }

    /// Notes the command during standstill in a growing push, if counts show its break-away in time.
    fn stand(&self, state: &mut ProbingState<N>) {
        let is_timed = state.servo.gain >= self.plan.timed_gain;
        let is_pushed = state.stage == ProbingStage::Push && state.extra > N::ZERO;
        if is_timed && is_pushed && state.still > self.plan.reaction {
            let command = state.given(self.plan.delay);
            if let Some(seen) = &mut state.broke_away {
                seen.stand(command, state.direction);
            }
        }
    }

    /// Takes a sample into the regression, and the estimate that it gives.
    fn regress(&self, state: &mut ProbingState<N>, increment: N) {
        // The command of this sample has been given since.
        let acted = state.given(self.plan.delay + 1);
        let direction = if state.stands {
            N::ZERO
        } else {
            state.motion_direction
        };
        let pending_estimate =
            self.regression
                .observe(&mut state.gathered, increment, direction, acted);
        let turns = state.reversals[0] + state.reversals[1];
        if pending_estimate
            && turns > 0
            && let Some(mut estimate) = state.gathered.estimate()
            && estimate.is_like(state.guessed)
        {
            if let Some(broke_away) = &state.broke_away {
                estimate.confine(broke_away, self.plan.command[1]);
            }
            if state.stage == ProbingStage::Push {
                state.push_on_with(&estimate);
            }
            state.observed.adopt(&state.servo, &estimate, acted);
            state.servo = estimate;
            state.is_new = true;
            if !self.regression.is_dense() {
                // Judged in the next sample: this one has done enough.
                return;
            }
        }
        if state.is_new {
            state.is_new = false;
            if state.evidence.is_none() && self.has_evidence(state) {
                state.evidence = Some(state.samples);
            }
        }
    }

    /// The limit that is exceeded, if any.
    fn left(&self, state: &ProbingState<N>) -> Option<Reason> {
        let [low, high] = self.plan.travel;
        if state.position < low || state.position > high {
            Some(Reason::TravelLeft)
        } else if state.samples > self.plan.longest && state.ending.is_none() {
            Some(Reason::TooLittleEvidence)
        } else {
            None
        }
    }

    fn progress(&self, state: &mut ProbingState<N>) -> Option<Result<(), Reason>> {
        let ending = state.ending?;
        state.ending_for = state.ending_for.saturating_add(1);
        let quiet = state.stage == ProbingStage::Hold && state.still >= self.plan.quiet;
        match ending {
            Err(Reason::TravelLeft) => Some(ending),
            _ if quiet => Some(ending),
            _ if state.ending_for > self.plan.settling => Some(Err(Reason::NeverAtRest)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::rough_model::Breakaway;
    use super::super::super::rough_model::RoughModel;
    use super::super::super::tests::unknown_servos::Unknown;
    use super::super::plan::COMMANDS;
    use super::*;

    impl<N: Number> Probing<N> {
        /// In the half-cycles of a servo that is known like this.
        pub(in super::super) fn pushing(&self, servo: &RoughModel<N>) -> ProbingState<N> {
            let mut state = ProbingState::new(&self.plan, None);
            state.servo = *servo;
            state.guessed = servo.gain;
            self.choose_half_cycle(&mut state);
            state.enter(ProbingStage::Push);
            state
        }
    }

    /// Two half-cycles of a tenth of the relay's shortest one, at half of the planned speed, end it. This holds at
    /// every rate. The loop then holds with 0.4 of its bandwidth, 0.16 of its stiffness.
    #[test]
    fn a_servo_whose_relay_rings_is_held_with_less_bandwidth() {
        for sample_time in [4e-3, 1e-3, 5e-5] {
            let unknown = Unknown {
                sample_time,
                held: None,
                ..Unknown::from_seed(2)
            };
            let probing = Probing::<f32>::new(&unknown.settings()).expect("allowed");
            let servo = RoughModel {
                gain: 0.01,
                per_gain: 100.0,
                ..RoughModel::default()
            };
            let mut state = probing.pushing(&servo);
            let half_cycle = (0.1 * 2.0 * probing.plan.half_cycle_speed).round().max(1.0) as u32;
            let speed = 0.5 * probing.plan.usable_speed;
            let half_cycles = |sample: &u32| sample / half_cycle;
            let ended = (0..5 * half_cycle).find(|sample| {
                let motion_direction = if half_cycles(sample) % 2 == 0 {
                    1.0
                } else {
                    -1.0
                };
                state.position += motion_direction * speed;
                probing.end_ringing(&mut state);
                state.ending.is_some()
            });
            assert_eq!(ended.as_ref().map(half_cycles), Some(2), "{sample_time}");
            assert_eq!(state.ending, Some(Err(Reason::Oscillating)));
            let pulled = |held_by| {
                let mut held = state;
                held.held_by = held_by;
                held.position = held.held_at + 10.0;
                probing.hold(&mut held)
            };
            let [usual, part] = [1.0, state.held_by].map(pulled);
            assert!((part / usual - 0.16).abs() < 1e-4, "{}", part / usual);
        }
    }

    /// A push against friction of 2 of 10 command units, after a break-away in the other direction.
    fn pushing(motion_direction: f32) -> (Probing<f32>, ProbingState<f32>) {
        let unknown = Unknown {
            held: None,
            ..Unknown::from_seed(2)
        };
        let probing = Probing::new(&unknown.settings()).expect("allowed");
        let gain = 2.0 * probing.plan.timed_gain;
        let servo = RoughModel {
            gain,
            per_gain: 1.0 / gain,
            forward: -2.0 * gain,
            backward: 2.0 * gain,
            viscous: 0.0,
        };
        let mut state = probing.pushing(&servo);
        state.aim(motion_direction);
        state.extra = 1.0;
        state.broke_away = Some(Breakaway {
            command: -2.0 * motion_direction,
            is_forward: motion_direction < 0.0,
            other: None,
        });
        (probing, state)
    }

    #[test]
    fn only_a_push_that_grows_against_rest_shows_the_other_break_away() {
        for motion_direction in [1.0, -1.0] {
            let shown = |change: fn(&mut ProbingState<f32>)| {
                let (probing, mut state) = pushing(motion_direction);
                state.commands = [3.0 * motion_direction; COMMANDS];
                state.still = probing.plan.reaction + 1;
                change(&mut state);
                probing.stand(&mut state);
                state.broke_away.and_then(|seen| seen.other)
            };
            assert_eq!(shown(|_| {}), Some(3.0 * motion_direction));
            assert_eq!(shown(|state| state.extra = 0.0), None);
            assert_eq!(shown(|state| state.still = 0), None);
            assert_eq!(shown(|state| state.stage = ProbingStage::Brake), None);
            // A count comes long after such a servo has broken away.
            assert_eq!(shown(|state| state.servo.gain *= 0.4), None);
        }
    }

    #[test]
    fn a_late_push_does_not_add_friction_that_the_model_has_learnt_since() {
        for motion_direction in [1.0, -1.0] {
            for (friction, extra) in [(2.75, 0.25), (4.0, 0.0), (1.0, 1.0)] {
                let (_, mut state) = pushing(motion_direction);
                let mut servo = state.servo;
                servo.forward = -friction * servo.gain;
                servo.backward = friction * servo.gain;
                state.push_on_with(&servo);
                assert!((state.extra - extra).abs() < 1e-5, "{}", state.extra);
            }
        }
    }
}
