use super::super::crude::Crude;
use super::state::{FirstCount, Stage, WiggleState};
use super::wiggling::Wiggle;
use crate::commission::StopReason;
use crate::number::Number;

/// How the servo broke away: the command, and the gain that goes with it.
struct Breakaway<N> {
    command: N,
    gain: N,
}

impl<N: Number> Wiggle<N> {
    /// The command grows until the servo has moved with it.
    pub(super) fn seek(&self, state: &mut WiggleState<N>) -> N {
        let plan = &self.plan;
        if state.still > plan.standing {
            state.origin = state.position;
            state.first_count = None;
        }
        let moved = state.position - state.origin;
        if state.first_count.is_none() && moved != N::ZERO {
            state.first_count = Some(FirstCount {
                sample: state.samples,
                command: state.given(plan.delay),
            });
        }
        if moved.magnitude() >= plan.noticed {
            if let Some(estimate) = state.gathered.sure() {
                return self.know(state, &estimate);
            }
            let along = moved * state.direction > N::ZERO;
            if along && let Some(breakaway) = self.breakaway(state, moved) {
                self.guess(state, &breakaway);
                let guess = state.servo;
                return self.know(state, &guess);
            }
            if along {
                // Not the ramp has moved it: it must be caught.
                state.held += state.direction * state.ramp;
                state.ramp = N::ZERO;
                state.direction = -state.direction;
            } else if state.observed.velocity * state.direction > N::ZERO {
                // Caught: from here it goes with the ramp.
                state.origin = state.position;
                state.first_count = None;
            }
        }
        let [least, most] = plan.command;
        let command = state.held + state.direction * state.ramp;
        if command > most || command < least {
            if state.still > plan.standing && state.ending.is_none() {
                state.ending = Some(Err(StopReason::DoesNotMove));
                state.held_at = state.position;
                state.enter(Stage::Hold);
            }
            return command;
        }
        state.ramp += self.ramp_step(state, moved);
        state.held + state.direction * state.ramp
    }

    /// The next step of the ramp: the faster, the sooner a servo that moves on its own would be too far or
    /// too fast.
    fn ramp_step(&self, state: &WiggleState<N>, moved: N) -> N {
        let plan = &self.plan;
        let usual = (plan.first_step + plan.growth * state.ramp).limited(N::ZERO, plan.steepest);
        let against = -(state.direction * state.observed.velocity);
        if moved.magnitude() < plan.noticed || against <= N::ZERO {
            return usual;
        }
        let [low, high] = plan.usable;
        let room = if state.direction > N::ZERO {
            state.position - low
        } else {
            high - state.position
        };
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
        let growth = (N::from_f64(4.0) * soon).limited(plan.growth, N::from_f64(0.5));
        let urgent = N::from_f64(4.0) * plan.first_step + growth * state.ramp;
        if urgent > usual { urgent } else { usual }
    }

    /// Where the command was when the servo broke away: a command that grows evenly from there on moves it
    /// as the cube of time. None if the ramp had not begun then.
    fn breakaway(&self, state: &WiggleState<N>, moved: N) -> Option<Breakaway<N>> {
        let plan = &self.plan;
        let now = state.given(plan.delay);
        let first = state.first_count?;
        let samples = state
            .samples
            .checked_sub(first.sample)
            .filter(|&since| since > 0)?;
        let since = N::from_count(samples.min(1 << 20) as i32);
        let slope = (now - first.command).magnitude() * since.reciprocal();
        let all = since * plan.since_beginning;
        let command = now - state.direction * slope * all;
        let possible = slope > N::ZERO && state.direction * (command - state.held) >= N::ZERO;
        possible.then(|| {
            let way = moved.magnitude() - N::from_f64(0.5);
            let gain = N::from_f64(6.0) * way * (slope * all * all * all).reciprocal();
            Breakaway { command, gain }
        })
    }

    /// Brakes a servo of which there is an estimate now.
    fn know(&self, state: &mut WiggleState<N>, servo: &Crude<N>) -> N {
        let plan = &self.plan;
        let acted = state.given(plan.delay);
        state.observed.adopt(&Crude::UNKNOWN, servo, acted);
        // What friction makes different in the other direction is not known: a part of what the command can
        // do.
        let (none, weight) = (N::ZERO, (servo.gain * plan.command[1]).reciprocal());
        state
            .gathered
            .expect(&[none, weight, -weight, none, none], none);
        state.servo = *servo;
        state.direction = if state.observed.velocity < N::ZERO {
            -N::ONE
        } else {
            N::ONE
        };
        self.choose_swing(state);
        state.enter(Stage::Brake);
        self.brake(state)
    }

    /// A first guess, and how far it can be trusted.
    fn guess(&self, state: &mut WiggleState<N>, breakaway: &Breakaway<N>) {
        let plan = &self.plan;
        let Breakaway { command, gain } = *breakaway;
        let without = -(gain * command);
        state.servo = Crude {
            gain,
            per_gain: gain.reciprocal(),
            forward: without,
            backward: without,
            viscous: N::ZERO,
        };
        // In roundings: half of b, a tenth of the limit's acceleration in breaking away.
        let rounding = N::from_f64(0.3);
        let sure = N::from_f64(2.0) * rounding * gain.reciprocal();
        let usual = N::from_f64(10.0) * rounding * (gain * plan.command[1]).reciprocal();
        let none = N::ZERO;
        state
            .gathered
            .expect(&[sure, none, none, none, none], sure * gain);
        // Half of a sample in the delay.
        state.gathered.expect(&[none, none, none, none, sure], none);
        let (forward, backward) = if state.direction > N::ZERO {
            (usual, none)
        } else {
            (none, usual)
        };
        state
            .gathered
            .expect(&[usual * command, forward, backward, none, none], none);
    }
}
