use super::super::StopReason;
use super::follower::Gone;
use crate::model::Phase;
use crate::number::Number;

/// How a model's position would change with effects that it does not have, each of a size that is
/// fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lacking<N> {
    pub(super) positions: [N; EFFECTS],
    velocities: [N; EFFECTS],
    /// a, 1/sample.
    viscous: N,
    gain: N,
    /// Rad per count; 1/v in friction that fades with speed v, samples per count.
    resolution: N,
    per_low_speed: N,
    position: N,
    direction: N,
}

/// Sizes of effects.
pub(super) const EFFECTS: usize = 6;

/// Which sizes belong to an effect.
pub(super) const OF: [(StopReason, [bool; EFFECTS]); 5] = [
    (
        StopReason::LacksLowSpeedFriction,
        [true, false, false, false, false, false],
    ),
    (
        StopReason::LacksGravity,
        [false, true, true, false, false, false],
    ),
    (
        StopReason::LacksDeadBand,
        [false, false, false, true, false, false],
    ),
    (
        StopReason::LacksResonance,
        [false, false, false, false, true, false],
    ),
    (
        StopReason::LacksBacklash,
        [false, false, false, false, false, true],
    ),
];

/// The last two show in the position at once.
const ACCELERATING: usize = 4;

impl<N: Number> Lacking<N> {
    /// For a model of a, b (samples), a resolution (rad) and the speed below which friction is another
    /// (counts per sample, positive).
    pub(super) fn new(viscous: N, gain: N, resolution: N, low_speed: N) -> Self {
        Self {
            positions: [N::ZERO; EFFECTS],
            velocities: [N::ZERO; EFFECTS],
            viscous,
            gain,
            resolution,
            per_low_speed: low_speed.reciprocal(),
            position: N::ZERO,
            direction: N::ZERO,
        }
    }

    /// The model has gone over a step.
    pub(super) fn advance(&mut self, gone: &Gone<N>) {
        let half = N::from_f64(0.5);
        let moving = gone.phase.moving_part();
        let direction = gone.phase.mean_direction();
        let (sine, cosine) = ((self.position + half * gone.way) * self.resolution).sine_cosine();
        self.position += gone.way;
        let time = gone.time;
        let relative = gone.way * time.reciprocal() * self.per_low_speed;
        // 1/(1 + x²)², a bell without a transcendental.
        let bell = (N::ONE + relative * relative).reciprocal();
        let command = if gone.command > N::ZERO {
            N::ONE
        } else if gone.command < N::ZERO {
            -N::ONE
        } else {
            N::ZERO
        };
        let own = [
            -(direction * bell * bell),
            sine,
            cosine,
            -(self.gain * command),
        ];
        let kept = match gone.phase {
            Phase::Slid { .. } => N::ONE,
            Phase::Turned { slowing, .. } => slowing,
            Phase::Stuck | Phase::Stopped { .. } => N::ZERO,
        };
        for i in 0..ACCELERATING {
            let velocity = self.velocities[i];
            let change = (own[i] - self.viscous * velocity) * moving * time;
            self.positions[i] += (velocity + half * change) * moving * time;
            self.velocities[i] = (velocity + change) * kept;
        }
        if gone.way > N::ZERO {
            self.direction = N::ONE;
        } else if gone.way < N::ZERO {
            self.direction = -N::ONE;
        }
        self.positions[ACCELERATING] = gone.change * time.reciprocal();
        self.positions[ACCELERATING + 1] = self.direction;
    }
}
