use super::super::rough_model::{Breakaway, RoughModel};
use super::experiment::Probing;
use super::state::{FirstCount, FreeMotion, Guess, ProbingStage, ProbingState};
use identifier_core::number::Number;
use identifier_core::reason::Reason;

/// The shortest informative fall, counts.
const MIN_FREE_MOTION_COUNTS: f64 = 3.0;

impl<N: Number> Guess<N> {
    /// For a servo that fell and was caught. At its furthest point, w t²/2 + b ∬u = q, its velocity is back at zero, w
    /// t + b ∫u = 0. None if no push had acted there.
    fn caught(free_motion: &[N; 4], base: N) -> Option<Self> {
        let [time, pushed, motion_direction, moved] = *free_motion;
        let half = N::from_f64(0.5);
        let against = (motion_direction - half * pushed * time).magnitude();
        let gain = moved.magnitude() * against.reciprocal();
        let acceleration = -(gain * pushed * time.reciprocal());
        let guess = Self {
            gain,
            without: acceleration - gain * base,
            forward: moved > N::ZERO,
            broke_away: None,
            speed: N::ZERO,
        };
        (guess.gain > N::ZERO && guess.without.is_finite()).then_some(guess)
    }
}

/// x^(1/3) from 0 to 1, to a fiftieth: x^(1/4 + 1/16 + 1/64).
fn cube_root<N: Number>(x: N) -> N {
    let root = |x: N| x.reciprocal_root().reciprocal_root();
    let fourth = root(x);
    let sixteenth = root(fourth);
    fourth * sixteenth * root(sixteenth)
}

impl<N: Number> Probing<N> {
    /// The command grows until the servo has moved with it.
    pub(super) fn seek(&self, state: &mut ProbingState<N>) -> N {
        let plan = &self.plan;
        let acted = state.given(plan.delay);
        let furthest = state.free_motion.furthest[3];
        let fell = furthest.magnitude() >= plan.noticed && furthest * state.direction < N::ZERO;
        if state.still > plan.standing
            && fell
            && let Some(guess) = Guess::caught(&state.free_motion.furthest, state.free_motion.base)
        {
            return self.know(state, &guess, acted);
        }
        if state.still > plan.standing {
            state.origin = state.position;
            state.first_count = None;
            state.free_motion = FreeMotion::from(acted);
        }
        let moved = state.position - state.origin;
        state.free_motion.follow(acted, moved);
        if state.first_count.is_none() && moved != N::ZERO {
            state.first_count = Some(FirstCount {
                sample: state.samples,
                command: acted,
                moved: moved.magnitude(),
            });
        }
        let furthest = state.free_motion.furthest[3];
        let against = -(state.direction * state.observed.velocity);
        if furthest * state.direction < N::ZERO && against > N::ZERO {
            let (direction, given) = (state.direction, state.given(0));
            let caught = state
                .free_motion
                .turns(direction, against, given, plan.horizon);
            if let Some(guess) = caught {
                return self.know(state, &guess, acted);
            }
        }
        let comes_back = (moved - furthest) * state.direction > N::ZERO;
        if furthest.magnitude() >= plan.noticed && self.is_timed(state, moved) {
            if furthest * state.direction > N::ZERO {
                if let Some(guess) = self.breakaway(state, moved, acted) {
                    return self.know(state, &guess, acted);
                }
                self.catch(state);
            } else if comes_back
                && let Some(guess) =
                    Guess::caught(&state.free_motion.turning(), state.free_motion.base)
            {
                return self.know(state, &guess, acted);
            }
        } else if comes_back && furthest * state.direction < N::ZERO {
            if furthest.magnitude() >= N::from_f64(MIN_FREE_MOTION_COUNTS)
                && let Some(guess) =
                    Guess::caught(&state.free_motion.turning(), state.free_motion.base)
            {
                return self.know(state, &guess, acted);
            }
            // It fell a little, and goes with the ramp from here.
            state.origin = state.position;
            state.first_count = None;
            state.free_motion = FreeMotion::from(acted);
        }
        let [least, most] = plan.command;
        let command = state.held + state.direction * state.ramp;
        if command > most || command < least {
            if state.is_jammed(plan) && state.ending.is_none() {
                state.ending = Some(Err(Reason::DoesNotMove));
                state.held_at = state.position;
                state.enter(ProbingStage::Hold);
            }
            return command;
        }
        state.ramp += self.ramp_step(state, moved);
        state.held + state.direction * state.ramp
    }

    /// The next step of the ramp. It is the faster, the sooner a servo that moves alone would be too far or too fast.
    fn ramp_step(&self, state: &ProbingState<N>, moved: N) -> N {
        let plan = &self.plan;
        let usual = plan.ramp.step(state.ramp);
        let against = -(state.direction * state.observed.velocity);
        if moved.magnitude() < plan.noticed || against <= N::ZERO {
            return usual;
        }
        let room = plan.half_room + state.direction * state.position;
        let faster = -(state.direction * state.observed.acceleration);
        let brakes = -faster;
        if brakes * room > N::from_f64(0.7) * against * against {
            return N::ZERO;
        }
        // Per sample: the reciprocal of the time that is left.
        let one = |rate: N, left: N| {
            if left > N::ZERO {
                rate * left.reciprocal()
            } else {
                N::ONE
            }
        };
        let by_travel = one(against, room);
        let by_speed = one(faster, plan.usable_speed - against);
        let soon = if by_travel > by_speed {
            by_travel
        } else {
            by_speed
        };
        let careful = N::from_f64(0.3) * plan.ramp.growth;
        let growth = (N::from_f64(4.0) * soon).limited(careful, N::from_f64(0.5));
        N::from_f64(4.0) * growth * plan.ramp.first_step * plan.per_growth + growth * state.ramp
    }

    /// True if the samples since the first count suffice for the time of the break-away. Also true if the travel
    /// permits no more of them.
    fn is_timed(&self, state: &ProbingState<N>, moved: N) -> bool {
        /// Samples.
        const TIMED: u32 = 4;
        let since = |first: FirstCount<N>| state.samples.saturating_sub(first.sample);
        state.first_count.is_some_and(|first| since(first) >= TIMED)
            || moved.magnitude() >= self.plan.much
    }

    /// The command at the break-away; `now` is the present one. A command that grows linearly from there on moves the
    /// servo as the cube of time, q = b u̇ t³/6. None if the ramp had not begun then.
    fn breakaway(&self, state: &ProbingState<N>, moved: N, now: N) -> Option<Guess<N>> {
        let plan = &self.plan;
        let first = state.first_count?;
        let samples = state
            .samples
            .checked_sub(first.sample)
            .filter(|&since| since > 0)?;
        let since = N::from_count(samples.min(1 << 20) as i32);
        let slope = (now - first.command).magnitude() * since.reciprocal();
        let half = N::from_f64(0.5);
        let motion_direction = moved.magnitude() - half;
        let all = since
            * (N::ONE - cube_root((first.moved - half) * motion_direction.reciprocal()))
                .reciprocal();
        let command = now - state.direction * slope * all;
        // One that moves at the first of the ramp falls.
        let ramped = state.direction * (first.command - state.held);
        let possible = slope > N::ZERO && ramped > N::from_f64(6.0) * plan.ramp.first_step;
        let command = if state.direction * (command - state.held) < N::ZERO {
            state.held
        } else {
            command
        };
        let is_forward = state.direction > N::ZERO;
        possible.then(|| {
            let gain = N::from_f64(6.0) * motion_direction * (slope * all * all * all).reciprocal();
            Guess {
                gain,
                without: -(gain * command),
                forward: is_forward,
                broke_away: Some(Breakaway {
                    command,
                    is_forward,
                    other: None,
                }),
                speed: half * gain * slope * all * all,
            }
        })
    }

    /// Has the ramp grow against a motion that it has not made, to catch it.
    pub(super) fn catch(&self, state: &mut ProbingState<N>) {
        let (acted, guessed) = (state.given(self.plan.delay), state.servo);
        state
            .observed
            .adopt(&guessed, &RoughModel::default(), acted);
        state.servo = RoughModel::default();
        let [least, most] = self.plan.command;
        state.held = state.given(0).limited(least, most);
        (state.direction, state.ramp) = (-state.direction, N::ZERO);
        state.enter(ProbingStage::Seek);
    }

    /// Follows the first brake. True if the servo has been faster in the mean than when it was noticed, as the ramp explains
    /// it: it rubs less than at rest, and what was guessed from its break-away does not brake it.
    pub(super) fn is_to_be_caught(&self, state: &mut ProbingState<N>) -> bool {
        let acted = state.given(self.plan.delay);
        let moved = state.position - state.origin;
        state.free_motion.follow(acted, moved);
        let most = state.noticed_speed * state.free_motion.time;
        most > N::ZERO && state.direction * moved > most
    }

    /// Brakes a servo of which there is a guess now, under the command that acts.
    fn know(&self, state: &mut ProbingState<N>, guess: &Guess<N>, acted: N) -> N {
        let Guess { gain, without, .. } = *guess;
        let servo = RoughModel {
            gain,
            per_gain: gain.reciprocal(),
            forward: without,
            backward: without,
            viscous: N::ZERO,
        };
        state.observed.adopt(&RoughModel::default(), &servo, acted);
        state.servo = servo;
        (state.pending_estimate, state.noticed_speed) = (Some(*guess), guess.speed);
        state.aim(state.motion_direction);
        state.enter(ProbingStage::Brake);
        self.brake(state)
    }

    /// The remaining work, for which the first command of the brake does not wait. It keeps the guess, chooses the next
    /// half-cycle, and starts the regression with this knowledge.
    pub(super) fn begin_regression(&self, state: &mut ProbingState<N>, guess: &Guess<N>) {
        self.choose_half_cycle(state);
        let plan = &self.plan;
        let Guess {
            gain,
            without,
            forward,
            broke_away,
            ..
        } = *guess;
        (state.guessed, state.broke_away) = (gain, state.broke_away.or(broke_away));
        // Uncertainty: half of b, half a sample of delay, a tenth of the command's largest acceleration in one
        // direction, and all of that in the difference to the other.
        let none = N::ZERO;
        let two = N::from_f64(2.0);
        let half = plan.off * two * state.servo.per_gain;
        let all = plan.off * (gain * plan.command[1]).reciprocal();
        let tenth = N::from_f64(10.0) * all;
        let viscous = plan.off * plan.usual_viscous.reciprocal();
        let (one, other) = if forward {
            (tenth, none)
        } else {
            (none, tenth)
        };
        let gathered = &mut state.gathered;
        gathered.forget();
        gathered.expect(&[half, none, none, none, none], half * gain);
        gathered.expect(&[none, one, other, none, none], tenth * without);
        gathered.expect(&[none, all, -all, none, none], none);
        gathered.expect(&[none, none, none, viscous, none], none);
        gathered.expect(&[none, none, none, none, half], none);
    }
}
