use super::delayed::{Acting, Delayed};
use super::motion::Piece;
use super::{A, B, COULOMB, DELAY, LOAD, POSITION, UNKNOWNS, VELOCITY};
use crate::model::{FrictionStep, Phase, Response};
use crate::number::Number;

/// A model that starts beside the servo and goes where the recorded command drives it, with its tangents:
/// how its position depends on each of the unknowns, exact but for terms of third order in the time of a
/// piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Follower<N> {
    unknowns: [N; UNKNOWNS],
    response: Response<N>,
    inputs: Delayed<N>,
    /// The servo's position less the model's, counts.
    pub(super) error: N,
    velocity: N,
    /// ∂position/∂unknown and ∂velocity/∂unknown.
    pub(super) positions: [N; UNKNOWNS],
    velocities: [N; UNKNOWNS],
}

/// A model's motion over a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gone<N> {
    pub(super) way: N,
    pub(super) acceleration: N,
    pub(super) phase: Phase<N>,
    /// What acted.
    pub(super) command: N,
}

impl<N: Number> Follower<N> {
    /// Before the first piece.
    pub(super) fn new(step: &FrictionStep<N>, unknowns: &[N; UNKNOWNS], first_command: N) -> Self {
        let mut positions = [N::ZERO; UNKNOWNS];
        let mut velocities = [N::ZERO; UNKNOWNS];
        positions[POSITION] = N::ONE;
        velocities[VELOCITY] = N::ONE;
        Self {
            unknowns: *unknowns,
            response: step.step.response(unknowns[A]),
            inputs: Delayed::before(first_command),
            error: -unknowns[POSITION],
            velocity: unknowns[VELOCITY],
            positions,
            velocities,
        }
    }

    /// Moves over a piece.
    pub(super) fn advance(&mut self, step: &FrictionStep<N>, piece: &Piece<N>) -> Gone<N> {
        let [x, gain, coulomb] = [A, B, COULOMB].map(|i| self.unknowns[i]);
        let acting = self.inputs.take(piece, self.unknowns[DELAY]);
        let drive = gain * acting.command + self.unknowns[LOAD];
        let before = self.velocity;
        let (motion, phase) = step.process_with(&self.response, x, drive, coulomb, before);
        let moving = phase.moving_part();
        self.error += piece.travel - motion.increment - gain * acting.lead * moving;
        self.velocity = motion.velocity;
        match phase {
            Phase::Stuck => {}
            Phase::Slid { direction } => {
                let response = self.response;
                self.slide(&response, N::ONE, motion.increment, direction, &acting);
            }
            Phase::Stopped { direction, part } => {
                let response = step.step.partial_response(x, part);
                self.slide(&response, part, motion.increment, direction, &acting);
                self.velocities = [N::ZERO; UNKNOWNS];
            }
            Phase::Turned {
                direction,
                part,
                slowing,
            } => {
                let half = N::from_f64(0.5);
                let response = step.step.partial_response(x, part);
                self.slide(&response, part, half * before * part, direction, &acting);
                for velocity in &mut self.velocities {
                    *velocity = *velocity * slowing;
                }
                let rest = N::ONE - part;
                let response = step.step.partial_response(x, rest);
                let way = half * motion.velocity * rest;
                self.slide(&response, rest, way, -direction, &acting);
            }
        }
        if !matches!(phase, Phase::Stuck) {
            self.positions[B] += acting.lead * moving;
            self.positions[DELAY] += gain * acting.lead_per_delay * moving;
        }
        Gone {
            way: motion.increment,
            acceleration: motion.velocity - before,
            phase,
            command: acting.command,
        }
    }

    /// The tangents over a `part` of a piece in which the model went one way.
    fn slide(&mut self, response: &Response<N>, part: N, way: N, direction: N, acting: &Acting<N>) {
        let gain = self.unknowns[B];
        let x = self.unknowns[A];
        // Mean velocity over the part; the part's length is in the response.
        let mean = if part > N::ZERO {
            way * part.reciprocal()
        } else {
            N::ZERO
        };
        let mut own = [N::ZERO; UNKNOWNS];
        own[A] = -mean;
        own[B] = acting.command;
        own[COULOMB] = -direction;
        own[DELAY] = gain * acting.command_per_delay;
        own[LOAD] = N::ONE;
        for i in 0..UNKNOWNS {
            let velocity = self.velocities[i];
            let acceleration = own[i] - x * velocity;
            self.positions[i] += velocity * part + response.way * acceleration;
            self.velocities[i] = velocity + response.velocity * acceleration;
        }
    }
}
