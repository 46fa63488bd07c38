use crate::fit::NumberedBlock;
use crate::number::Number;
use crate::reason::Reason;

/// The time in motion after which a first fit is overdue, s; longer if its record is.
pub(crate) const PATIENCE: f64 = 1.0;

/// The wait for a first fit: the time in motion without one, and the reason once that is too long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FirstFitWait {
    /// Blocks in motion.
    moving: u32,
    /// Blocks since the last one with a count.
    resting: u32,
    reason: Option<Reason>,
    /// A first fit has succeeded.
    is_over: bool,
}

impl FirstFitWait {
    pub(super) const START: Self = Self {
        moving: 0,
        resting: u32::MAX,
        reason: None,
        is_over: false,
    };

    /// A first fit has succeeded.
    pub(super) fn end(&mut self) {
        *self = Self {
            is_over: true,
            ..Self::START
        };
    }

    /// Takes a block; `patience` is in blocks.
    pub(super) fn take<N: Number>(&mut self, patience: u32, numbered: &NumberedBlock<N>) {
        /// At low speed counts are rare: a servo is in motion for this part of the patience after each.
        const REST_PER_PATIENCE: u32 = 20;
        self.resting = if numbered.block.travel == N::ZERO {
            self.resting.saturating_add(1)
        } else {
            0
        };
        if self.resting <= patience / REST_PER_PATIENCE {
            self.moving = self.moving.saturating_add(1);
        }
    }

    /// Takes the reason why a fit to a full record failed. True if the fit is overdue and the reason is new.
    pub(super) fn object(&mut self, patience: u32, reason: Reason) -> bool {
        let is_overdue = self.moving >= patience;
        let is_new = is_overdue && self.reason != Some(reason);
        if is_overdue {
            self.reason = Some(reason);
        }
        is_new
    }

    /// Why there is no first fit, once it is overdue.
    pub(super) fn reason(&self, patience: u32) -> Option<Reason> {
        // Slow or interrupted motion fills no record; until twice the time a first fit may be under way.
        let is_without_record = self.moving >= patience.saturating_mul(2);
        let fallback = is_without_record.then_some(Reason::TooLittleMotion);
        self.reason.or(fallback).filter(|_| !self.is_over)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Blocking, Recorder};

    const PATIENCE: u32 = 100;

    /// Takes blocks of which every n-th has a count.
    fn moved(wait: &mut FirstFitWait, blocks: u32, every: u32) {
        let blocking = Blocking::new(1);
        let mut recorder = Recorder::<f32>::default();
        recorder.push(&blocking, 0.0, 0.0);
        for k in 1..=blocks {
            let travel = if k % every == 0 { 1.0 } else { 0.0 };
            recorder.push(&blocking, travel, 0.0);
            if let Some(block) = recorder.take() {
                wait.take(PATIENCE, &block);
            }
        }
    }

    #[test]
    fn a_reason_is_reported_after_the_patience_in_motion_and_once() {
        let mut wait = FirstFitWait::START;
        moved(&mut wait, PATIENCE - 1, 1);
        assert!(!wait.object(PATIENCE, Reason::Reversed));
        moved(&mut wait, 1, 1);
        assert_eq!(wait.reason(PATIENCE), None);
        assert!(wait.object(PATIENCE, Reason::Reversed));
        assert_eq!(wait.reason(PATIENCE), Some(Reason::Reversed));
        assert!(!wait.object(PATIENCE, Reason::Reversed));
        assert!(wait.object(PATIENCE, Reason::DoesNotFollow));
    }

    #[test]
    fn after_a_first_fit_none_is_waited_for() {
        let mut wait = FirstFitWait::START;
        moved(&mut wait, PATIENCE, 1);
        assert!(wait.object(PATIENCE, Reason::Reversed));
        wait.end();
        assert_eq!(wait.reason(PATIENCE), None);
        moved(&mut wait, 3 * PATIENCE, 1);
        assert_eq!(wait.reason(PATIENCE), None);
    }

    #[test]
    fn a_servo_at_rest_is_not_waited_for_and_a_slow_one_is() {
        let mut wait = FirstFitWait::START;
        moved(&mut wait, 100 * PATIENCE, u32::MAX);
        let mut resting = FirstFitWait::START;
        resting.resting = u32::MAX;
        assert_eq!(wait, resting);
        moved(&mut wait, 2 * PATIENCE + 5, 6);
        assert_eq!(wait.reason(PATIENCE), Some(Reason::TooLittleMotion));
    }
}
