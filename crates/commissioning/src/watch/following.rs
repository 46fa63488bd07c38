//! True if a servo follows its setpoint as it did a moment ago.
//!
//! Loads act at any time while a drive is in operation. A controller that balances one changes its command without
//! effect on the motion, as with a dead actuator. But the servo follows: its error grows no further. If the command
//! does not act, or acts in the wrong direction, the error soon exceeds all errors of the last 0.4 s.

use identifier_core::number::Number;
use identifier_core::units::Units;

/// The intervals over which the largest errors are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Following {
    /// Samples.
    interval: i32,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct FollowingState<N> {
    /// The largest errors of the intervals before, and of this one, counts.
    before: [N; INTERVALS],
    now: N,
    /// The interval that is the oldest, and samples of this one.
    oldest: usize,
    samples: i32,
    /// The error of the last sample.
    error: N,
}

/// Intervals that are remembered.
const INTERVALS: usize = 8;

impl Following {
    /// An interval, s.
    const INTERVAL: f64 = 0.05;
    /// An error up to this many counts is none,
    const MIN_ERROR: i32 = 20;
    /// nor one of up to this many times the largest before.
    const GROWTH: f64 = 1.5;

    pub(super) fn new(units: &Units) -> Self {
        // A cast saturates.
        Self {
            interval: ((Self::INTERVAL / units.sample_time()) as i32).max(4),
        }
    }

    /// A sample of a servo under control, or of one that is not.
    #[inline]
    pub(super) fn process<N: Number>(
        &self,
        state: &mut FollowingState<N>,
        setpoint: Option<N>,
        position: N,
    ) {
        let Some(setpoint) = setpoint else {
            *state = FollowingState::default();
            return;
        };
        state.error = (setpoint - position).magnitude();
        if state.error > state.now {
            state.now = state.error;
        }
        state.samples += 1;
        if state.samples < self.interval {
            return;
        }
        if let Some(oldest) = state.before.get_mut(state.oldest) {
            *oldest = state.now;
        }
        state.oldest = (state.oldest + 1) % INTERVALS;
        (state.now, state.samples) = (N::ZERO, 0);
    }

    /// True if the error is no larger than errors were a moment ago.
    pub(super) fn follows<N: Number>(state: &FollowingState<N>) -> bool {
        let growth = N::from_f64(Self::GROWTH);
        state.error <= N::from_count(Self::MIN_ERROR)
            || state
                .before
                .iter()
                .any(|&before| state.error <= growth * before)
    }
}
