use super::super::crude::Crude;
use super::state::{FirstCount, Stage, WiggleState};
use super::wiggling::Wiggle;
use crate::commission::StopReason;
use crate::number::Number;

impl<N: Number> Wiggle<N> {
    /// The command grows until the servo has moved.
    pub(super) fn seek(&self, state: &mut WiggleState<N>) -> N {
        let plan = &self.plan;
        let command = state.held + state.direction * state.ramp;
        if state.first_count.is_none() && state.position != N::ZERO {
            state.first_count = Some(FirstCount {
                sample: state.samples,
                command: state.given(plan.delay),
            });
        }
        if state.position.magnitude() >= plan.noticed {
            self.notice(state);
            return self.brake(state);
        }
        let [least, most] = plan.command;
        if command > most || command < least {
            if state.ending.is_none() {
                state.ending = Some(Err(StopReason::DoesNotMove));
                state.held_at = state.position;
                state.enter(Stage::Hold);
            }
            return N::ZERO;
        }
        let step = plan.first_step + plan.growth * state.ramp;
        state.ramp += step.limited(N::ZERO, plan.steepest);
        state.held + state.direction * state.ramp
    }

    /// The servo has moved so far that its gain can be guessed: with the command growing evenly since it
    /// broke away, q = b u̇ t³/6.
    fn notice(&self, state: &mut WiggleState<N>) {
        let plan = &self.plan;
        let now = state.given(plan.delay);
        let (half, six) = (N::from_f64(0.5), N::from_f64(6.0));
        let moved = state.position.magnitude() - half;
        let direction = if state.position > N::ZERO {
            N::ONE
        } else {
            -N::ONE
        };
        let (since, change) = match state.first_count {
            Some(first) if state.samples > first.sample => (
                N::from_count((state.samples - first.sample).min(1 << 20) as i32),
                (now - first.command).magnitude(),
            ),
            _ => (N::ONE, plan.steepest),
        };
        let slope = change * since.reciprocal();
        let all = since * plan.since_beginning;
        let gain = six * moved * (slope * all * all * all).reciprocal();
        let breakaway = now - state.direction * slope * all;
        let before = state.servo;
        let without = -(gain * breakaway);
        state.servo = Crude {
            gain,
            per_gain: gain.reciprocal(),
            forward: without,
            backward: without,
            viscous: N::ZERO,
        };
        // In roundings: half of b, a fifth of breaking away.
        let sure = N::from_f64(0.6) * gain.reciprocal();
        let usual = N::from_f64(0.3) * (N::from_f64(0.1) * gain * plan.command[1]).reciprocal();
        state
            .gathered
            .expect(&[sure, N::ZERO, N::ZERO, N::ZERO], sure * gain);
        let (forward, backward) = if direction > N::ZERO {
            (usual, N::ZERO)
        } else {
            (N::ZERO, usual)
        };
        state
            .gathered
            .expect(&[usual * breakaway, forward, backward, N::ZERO], N::ZERO);
        // Friction makes it stronger than that; by how much is not known.
        let vague = N::from_f64(0.1) * usual;
        state
            .gathered
            .expect(&[N::ZERO, vague, -vague, N::ZERO], N::ZERO);
        let viscous = N::from_f64(0.3) * (N::from_f64(20.0) * plan.rate).reciprocal();
        state
            .gathered
            .expect(&[N::ZERO, N::ZERO, N::ZERO, viscous], N::ZERO);
        state.observed.adopt(&before, &state.servo, now);
        state.direction = direction;
        self.choose_swing(state);
        state.enter(Stage::Brake);
    }
}
