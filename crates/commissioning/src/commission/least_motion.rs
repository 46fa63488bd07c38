use super::RoughModel;
use identifier_core::number::Number;

/// The motion that a servo makes at least: one with half of the b that was identified and twice its friction, from rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LeastMotion<N> {
    /// Counts a sample, and counts.
    velocity: N,
    displacement: N,
}

impl<N: Number> LeastMotion<N> {
    /// At rest.
    pub(super) const NONE: Self = Self {
        velocity: N::ZERO,
        displacement: N::ZERO,
    };

    /// Takes the accelerations of the identified servo without friction, counts per sample²: by a sample's command, and by the
    /// least that moves a servo. Returns how far it has come, counts.
    pub(super) fn take(&mut self, servo: &RoughModel<N>, force: N, least: N) -> N {
        let [force, least] = [force, least].map(|of| N::from_f64(0.5) * of);
        let twice = servo.coulomb() + servo.coulomb();
        let friction = if twice > least { twice } else { least };
        let motion_direction = if self.velocity == N::ZERO {
            force
        } else {
            self.velocity
        };
        let braking = if motion_direction > N::ZERO {
            friction
        } else {
            -friction
        };
        let next = self.velocity + force - braking;
        // Friction stops it, and does not turn it round.
        self.velocity = if next * motion_direction > N::ZERO {
            next
        } else {
            N::ZERO
        };
        self.displacement += self.velocity;
        self.displacement
    }
}
