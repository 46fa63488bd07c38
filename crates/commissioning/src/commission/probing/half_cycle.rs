use super::super::noise::QUANTISATION_SIGMA;
use super::experiment::Probing;
use super::state::{ProbingStage, ProbingState};
use identifier_core::number::Number;
use identifier_core::reason::Reason;

impl<N: Number> Probing<N> {
    /// The part of an acceleration that is planned with. The rest corrects the rough model.
    const USED: f64 = 0.85;

    /// Acceleration and amplitude of the next half-cycle: the largest that command, travel and speed permit.
    pub(super) fn choose_half_cycle(&self, state: &mut ProbingState<N>) {
        let plan = &self.plan;
        let servo = &state.servo;
        let [least, most] = plan.command;
        let used = N::from_f64(Self::USED);
        let mut available = plan.usable_speed * plan.half_cycle_speed.reciprocal();
        for direction in [N::ONE, -N::ONE] {
            let without = servo.without_command(direction);
            let up = (servo.gain * most + without) * used;
            let down = -(servo.gain * least + without) * used;
            for one in [up, down] {
                if one < available {
                    available = one;
                }
            }
        }
        let half_room = plan.half_room;
        let floor = N::from_f64(0.02) * servo.gain * most;
        let mut acceleration = available.larger(floor);
        let mut amplitude = acceleration * plan.half_cycle;
        if amplitude > half_room {
            amplitude = half_room;
            acceleration = half_room * plan.half_cycle.reciprocal();
        } else if amplitude < plan.least_half_cycle {
            amplitude = plan.least_half_cycle.limited(N::ZERO, half_room);
            let most =
                plan.usable_speed * plan.usable_speed * N::from_f64(0.5) * amplitude.reciprocal();
            acceleration = acceleration.limited(N::ZERO, most);
        }
        state.acceleration = acceleration;
        state.amplitude = amplitude;
    }

    /// Position and velocity, along a direction, where a decision of now begins to act.
    fn ahead(&self, state: &ProbingState<N>, direction: N) -> [N; 2] {
        let plan = &self.plan;
        let horizon = plan.horizon;
        let velocity = direction * state.observed.velocity;
        let acceleration = direction * state.observed.acceleration;
        let pushed = acceleration.larger(N::ZERO);
        let position = direction * state.position;
        [
            position + horizon * (velocity + N::from_f64(0.5) * horizon * pushed),
            velocity + horizon * pushed,
        ]
    }

    /// The command of a half-cycle. Beyond the planned travel the servo is not pushed outwards. A load that moves on a
    /// spring makes the friction estimate too large, which would soften every brake.
    pub(super) fn half_cycle(&self, state: &mut ProbingState<N>) -> N {
        let command = match state.stage {
            ProbingStage::Brake => self.brake(state),
            ProbingStage::Stop => self.stop(state),
            _ => self.push(state),
        };
        let motion_direction = if command < N::ZERO { -N::ONE } else { N::ONE };
        if self.is_beyond(state, motion_direction) {
            N::ZERO
        } else {
            command
        }
    }

    /// True if the servo is beyond the travel that is planned with, on the side of a direction.
    fn is_beyond(&self, state: &ProbingState<N>, direction: N) -> bool {
        direction * state.position > self.plan.half_room
    }

    /// Accelerates until the servo must be braked to turn where it should.
    fn push(&self, state: &mut ProbingState<N>) -> N {
        let plan = &self.plan;
        let direction = state.direction;
        if direction * state.observed.velocity < N::ZERO && !state.stands {
            // It has not turned yet after all.
            return self.braking(state, -direction);
        }
        let [position, velocity] = self.ahead(state, direction);
        let braking = N::from_f64(Self::USED) * state.acceleration;
        let room = state.amplitude - position;
        let moves = velocity > N::ZERO;
        let must = moves
            && (N::from_f64(0.5) * velocity * velocity >= braking * room
                || velocity >= plan.usable_speed);
        if must {
            state.extra = N::ZERO;
            state.enter(ProbingStage::Brake);
            return self.braking(state, direction);
        }
        // One that does not begin to move needs more.
        let late = state.still > plan.reaction && state.samples - state.stage_since > plan.reaction;
        if late {
            let step = plan.ramp.first_step + plan.ramp.growth * state.extra;
            state.extra += step.limited(N::ZERO, plan.ramp.steepest + plan.ramp.steepest);
        }
        let command = state
            .servo
            .command(direction * state.acceleration, direction)
            + direction * state.extra;
        let [least, most] = plan.command;
        let all = command > most || command < least;
        if all && state.is_jammed(plan) {
            return self.hit_end_stop(state, command);
        }
        command
    }

    /// Full command does not move the servo in one direction, so the opposite direction is tried. If it moves there
    /// and again does not return, it can move in one direction only. Otherwise nothing moves it.
    fn hit_end_stop(&self, state: &mut ProbingState<N>, command: N) -> N {
        let direction = state.direction;
        if state.blocked.replace(direction).is_none() {
            self.turn_back(state);
            return command;
        }
        state.ending = Some(Err(Reason::DoesNotMove));
        state.held_at = state.position;
        state.enter(ProbingStage::Hold);
        self.hold(state)
    }

    /// Brakes until the servo turns.
    pub(super) fn brake(&self, state: &mut ProbingState<N>) -> N {
        if state.has_turned() {
            return self.turn(state);
        }
        // The sample of the guess has done enough.
        let is_first = state.reversals == [0; 2] && state.samples != state.stage_since;
        if is_first && self.is_to_be_caught(state) {
            self.catch(state);
            return state.held;
        }
        self.braking(state, state.direction)
    }

    /// The command that brakes, as hard as the room needs.
    fn braking(&self, state: &mut ProbingState<N>, direction: N) -> N {
        let plan = &self.plan;
        let [position, velocity] = self.ahead(state, direction);
        let half_room = plan.half_room;
        let room = half_room - position;
        let least_room = N::from_f64(0.04) * half_room;
        let room = room.larger(least_room);
        let needed = N::from_f64(0.65) * velocity * velocity * room.reciprocal();
        let braking = needed.larger(state.acceleration);
        let measured = -(direction * state.observed.acceleration);
        let waited = state.samples - state.stage_since > plan.reaction;
        if waited && measured < N::from_f64(0.5) * needed {
            let step = plan.ramp.first_step + plan.ramp.growth * state.extra;
            state.extra += step;
        }
        state.servo.command(-(direction * braking), direction) - direction * state.extra
    }

    /// The servo turns: the next half-cycle, or the end.
    fn turn(&self, state: &mut ProbingState<N>) -> N {
        state.extra = N::ZERO;
        if self.is_beyond(state, -state.direction) {
            // A spring has swung it back: the next push would be outwards.
            state.aim(state.direction);
            state.enter(ProbingStage::Push);
            return self.push(state);
        }
        let end = usize::from(state.direction > N::ZERO);
        state.reversals[end] += 1;
        if state.evidence.is_some() {
            state.aim(-state.direction);
            state.ending = Some(Ok(()));
            state.held_at = state.position;
            state.enter(ProbingStage::Hold);
            return self.hold(state);
        }
        self.turn_back(state);
        self.push(state)
    }

    /// From the next push on it moves in the other direction.
    fn turn_back(&self, state: &mut ProbingState<N>) {
        state.extra = N::ZERO;
        state.aim(-state.direction);
        self.choose_half_cycle(state);
        state.enter(ProbingStage::Push);
    }

    /// True if the servo is within tolerance. It has turned twice at either end, and the acceleration of a half-cycle
    /// is predicted in both directions.
    pub(super) fn has_evidence(&self, state: &ProbingState<N>) -> bool {
        /// The largest standard error of an acceleration, over it.
        const KNOWN: f64 = 0.008;
        if state.reversals.iter().any(|&count| count < 2) {
            return false;
        }
        let speed = state.acceleration * self.plan.half_cycle_speed * N::from_f64(0.5);
        let most = N::from_f64(KNOWN / QUANTISATION_SIGMA) * state.acceleration;
        let accelerated = [N::ONE, -N::ONE].map(|direction| {
            let acceleration = direction * state.acceleration;
            let command = state.servo.command(acceleration, direction);
            (command, direction * speed)
        });
        let variances = state.gathered.variances(&accelerated);
        variances.iter().all(|&variance| variance < most * most)
    }

    /// Brakes for good.
    pub(super) fn stop(&self, state: &mut ProbingState<N>) -> N {
        if state.samples == state.stage_since {
            state.aim(state.motion_direction);
        }
        if state.has_turned() {
            state.held_at = state.position;
            state.enter(ProbingStage::Hold);
            return self.hold(state);
        }
        self.braking(state, state.direction)
    }

    /// Holds the servo where it stopped.
    pub(super) fn hold(&self, state: &mut ProbingState<N>) -> N {
        let servo = &state.servo;
        let [stiffness, damping] = self.plan.hold;
        let off = state.position - state.held_at;
        let by = state.held_by;
        let back = by * (by * stiffness * off + damping * state.observed.velocity);
        servo.holding() - back * servo.per_gain
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::tests::unknown_servos::Unknown;
    use super::*;
    use crate::commission::RoughModel;

    const SIDES: [f32; 2] = [1.0, -1.0];

    /// A motion of a servo whose friction estimate is 8 of 10 command units. Gentle brakes then push along.
    fn rubbing() -> (Probing<f32>, ProbingState<f32>) {
        let unknown = Unknown {
            held: None,
            ..Unknown::from_seed(2)
        };
        let probing = Probing::new(&unknown.settings()).expect("allowed");
        let gain = 0.01;
        let servo = RoughModel {
            gain,
            per_gain: 1.0 / gain,
            forward: -8.0 * gain,
            backward: 8.0 * gain,
            viscous: 0.0,
        };
        let state = probing.pushing(&servo);
        (probing, state)
    }

    /// A part of the travel that is planned with, to a side.
    fn at_part(probing: &Probing<f32>, side: f32, part: f32) -> f32 {
        side * part * probing.plan.half_room
    }

    #[test]
    fn nothing_pushes_outwards_beyond_the_travel_that_is_planned_with() {
        for side in SIDES {
            for stage in [ProbingStage::Push, ProbingStage::Brake, ProbingStage::Stop] {
                let outwards = |part| {
                    let (probing, mut state) = rubbing();
                    state.position = at_part(&probing, side, part);
                    // It creeps outwards.
                    state.aim(side);
                    state.motion_direction = side;
                    state.observed.velocity = 0.01 * side;
                    state.samples = 1;
                    state.enter(stage);
                    state.samples = 2;
                    side * probing.half_cycle(&mut state)
                };
                assert!(outwards(0.999) > 0.0, "{side} {stage:?}");
                assert!(outwards(1.001) <= 0.0, "{side} {stage:?}");
            }
        }
    }

    #[test]
    fn a_servo_that_a_spring_turns_beyond_the_travel_is_pushed_inwards_again() {
        for side in SIDES {
            let turned = |part| {
                let (probing, mut state) = rubbing();
                state.position = at_part(&probing, side, part);
                // It was on its way back, and has been turned by a count.
                state.aim(-side);
                state.extreme -= side;
                state.enter(ProbingStage::Brake);
                let command = probing.half_cycle(&mut state);
                (side * state.direction, side * command, state.reversals)
            };
            let (direction, command, reversals) = turned(0.999);
            assert!(direction > 0.0 && command > 0.0, "{direction} {command}");
            assert_eq!(reversals[0] + reversals[1], 1);
            let (direction, command, reversals) = turned(1.001);
            assert!(direction < 0.0 && command < 0.0, "{direction} {command}");
            assert_eq!(reversals, [0; 2]);
        }
    }
}
