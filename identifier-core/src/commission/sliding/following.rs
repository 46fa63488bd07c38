use super::plan::Motion;
use crate::number::Number;

/// Whether a servo follows the reference of a slide, which waits for one that breaks away late.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Following {
    /// Samples in which it has not followed.
    left: u32,
}

impl Following {
    /// The error of a servo that does not stand but leaves its reference, over the one up to which it follows, and the
    /// samples that each with such an error counts for.
    const LOST: f64 = 1.3;
    const LOST_WEIGHT: u32 = 8;

    pub(super) const START: Self = Self { left: 0 };

    /// Takes the error of the loop in a sample; true if the servo follows.
    #[inline]
    pub(super) fn take<N: Number>(&mut self, error: N, motion: &Motion<N>) -> bool {
        let error = error.magnitude();
        if error <= motion.max_error {
            self.left = 0;
            return true;
        }
        // The integral of the loop finds the command at which one that stands breaks away.
        let is_lost = error > N::from_f64(Self::LOST) * motion.max_error;
        let weight = if is_lost { Self::LOST_WEIGHT } else { 1 };
        self.left = self.left.saturating_add(weight);
        false
    }

    /// True if it has not followed for too long.
    pub(super) fn is_over<N: Number>(self, motion: &Motion<N>) -> bool {
        self.left > motion.patience
    }
}
