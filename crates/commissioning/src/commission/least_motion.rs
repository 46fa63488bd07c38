use identifier_core::number::Number;

/// Counts that must have become a motion.
pub(super) const MISSED: f64 = 20.0;

/// The motion from rest that an identified servo makes at least: with half of its b, against twice its friction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LeastMotion<N> {
    /// Counts a sample, and counts.
    velocity: N,
    displacement: N,
    /// Samples since it was a motion.
    since: u32,
}

impl<N: Number> LeastMotion<N> {
    /// Takes the accelerations by a sample's command beyond the load and by friction, counts per sample². The command is positive
    /// in the direction of the motion.
    pub(super) fn take(&mut self, command: N, friction: N) {
        let next = self.velocity + N::from_f64(0.5) * command - friction;
        self.velocity = if next > N::ZERO { next } else { N::ZERO };
        self.displacement += self.velocity;
        if self.displacement > N::from_f64(MISSED) {
            self.since = self.since.saturating_add(1);
        }
    }

    /// True once a motion must have been seen of commands that act so many samples late.
    pub(super) fn is_due(&self, delay: u32) -> bool {
        self.since > delay
    }
}
