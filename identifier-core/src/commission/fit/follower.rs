use super::inputs::{HeldCommand, Inputs};
use super::motion::MotionRecord;
use super::{A, B, COULOMB, DELAY, LOAD, POSITION, UNKNOWNS, VELOCITY};
use crate::model::{FrictionPhase, FrictionStep, Response};
use crate::number::Number;

/// A model that starts beside the servo and goes where the recorded command drives it, with its tangents:
/// how its position depends on each of the unknowns, exact but for terms of third order in the time of a
/// step. Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Follower<N> {
    unknowns: [N; UNKNOWNS],
    inputs: Inputs<N>,
    /// The servo's position less the model's, counts.
    pub(super) error: N,
    velocity: N,
    /// ∂position/∂unknown and ∂velocity/∂unknown.
    pub(super) positions: [N; UNKNOWNS],
    velocities: [N; UNKNOWNS],
}

impl<N: Number> Follower<N> {
    /// Before the first piece of a record.
    pub(super) fn new<const W: usize>(
        unknowns: &[N; UNKNOWNS],
        motion: &MotionRecord<N, W>,
    ) -> Self {
        let mut positions = [N::ZERO; UNKNOWNS];
        let mut velocities = [N::ZERO; UNKNOWNS];
        positions[POSITION] = N::ONE;
        velocities[VELOCITY] = N::ONE;
        Self {
            unknowns: *unknowns,
            inputs: Inputs::delayed(motion, unknowns[DELAY]),
            error: -unknowns[POSITION],
            velocity: unknowns[VELOCITY],
            positions,
            velocities,
        }
    }

    /// Moves over a piece of the record, in as many steps as commands act in it.
    pub(super) fn advance<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        motion: &MotionRecord<N, W>,
        index: usize,
    ) {
        let Some(piece) = motion.get(index) else {
            return;
        };
        let mut inputs = self.inputs;
        inputs.over(motion, piece.samples, |acting| {
            if acting.time > N::ZERO {
                self.advance_under(step, acting);
            }
            if self.velocity != N::ZERO {
                self.velocities[DELAY] += self.unknowns[B] * acting.step;
            }
        });
        self.inputs = inputs;
        self.error += piece.travel;
    }

    fn advance_under(&mut self, step: &FrictionStep<N>, acting: &HeldCommand<N>) {
        let [a, gain, coulomb] = [self.unknowns[A], self.unknowns[B], self.unknowns[COULOMB]];
        let time = acting.time;
        let square = time * time;
        let x = a * time;
        let drive = gain * acting.command + self.unknowns[LOAD];
        let before = self.velocity;
        let whole = step.step.response(x);
        let (motion, phase) =
            step.process_with(&whole, x, drive * square, coulomb * square, before * time);
        let moving = phase.moving_part();
        let lead = acting.lead * square * moving;
        self.error = self.error - motion.increment - gain * lead;
        self.velocity = motion.velocity * time.reciprocal();
        let after = self.velocity;
        let half = N::from_f64(0.5);
        match phase {
            FrictionPhase::Stuck => {}
            FrictionPhase::Slid { direction } => {
                self.slide(step, time, half * (before + after), direction, acting);
            }
            FrictionPhase::Stopped { direction, part } => {
                self.slide(step, part * time, half * before, direction, acting);
                self.velocities = [N::ZERO; UNKNOWNS];
            }
            FrictionPhase::Turned {
                direction,
                part,
                slowing,
            } => {
                self.slide(step, part * time, half * before, direction, acting);
                for velocity in &mut self.velocities {
                    *velocity = *velocity * slowing;
                }
                let rest = (N::ONE - part) * time;
                self.slide(step, rest, half * after, -direction, acting);
            }
        }
        self.positions[B] += lead;
    }

    /// The tangents over a time in which the model went one way with a mean velocity.
    fn slide(
        &mut self,
        step: &FrictionStep<N>,
        time: N,
        mean: N,
        direction: N,
        acting: &HeldCommand<N>,
    ) {
        let gain = self.unknowns[B];
        let a = self.unknowns[A];
        let whole = step.step.response(a * time);
        let response = Response {
            way: whole.way * time * time,
            velocity: whole.velocity * time,
        };
        let mut own = [N::ZERO; UNKNOWNS];
        own[A] = -mean;
        own[B] = acting.command;
        own[COULOMB] = -direction;
        own[DELAY] = gain * acting.falls;
        own[LOAD] = N::ONE;
        for i in 0..UNKNOWNS {
            let velocity = self.velocities[i];
            let acceleration = own[i] - a * velocity;
            self.positions[i] += velocity * time + response.way * acceleration;
            self.velocities[i] = velocity + response.velocity * acceleration;
        }
    }
}
