use super::plan::Motion;
use identifier_core::number::Number;

/// Whether a servo follows the reference of a motion, which waits for one that breaks away late.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Following {
    /// Samples in which it has not followed.
    left: u32,
}

impl Following {
    /// The error of a servo that moves away from its reference, over the error up to which it follows. Each sample
    /// with such an error counts as this many.
    const LOST: f64 = 1.3;
    const LOST_WEIGHT: u32 = 8;

    /// The part of the speed beyond which a servo that leaves its reference was pushed.
    const PUSHED_SPEED: f64 = 0.3;

    /// Takes the error of the loop in a sample; true if the servo follows.
    #[inline]
    pub(super) fn take<N: Number>(&mut self, error: N, motion: &Motion<N>) -> bool {
        let error = error.magnitude();
        if error <= motion.max_error {
            self.left = 0;
            return true;
        }
        // At standstill the integral of the loop grows to the command at which the servo breaks away.
        let is_lost = error > N::from_f64(Self::LOST) * motion.max_error;
        let weight = if is_lost { Self::LOST_WEIGHT } else { 1 };
        self.left = self.left.saturating_add(weight);
        false
    }

    /// True if it has not followed for too long.
    pub(super) fn is_over<N: Number>(self, motion: &Motion<N>) -> bool {
        self.left > motion.patience
    }

    /// True if the servo runs away from its reference. Friction cannot cause that: it is a load for which the loop of
    /// the motions is too slow.
    pub(super) fn is_pushed<N: Number>(error: N, velocity: N, motion: &Motion<N>) -> bool {
        let fast = N::from_f64(Self::PUSHED_SPEED) * motion.speed;
        error.magnitude() > motion.max_error
            && velocity.magnitude() > fast
            && error * velocity < N::ZERO
    }
}
