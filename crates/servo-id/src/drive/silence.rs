//! The silence of a drive, of which only the time counts in which this program listened.

use std::time::{Duration, Instant};

/// The longest time between two calls that counts as listened to. Waits for a report last 50 ms or less. A program that
/// was suspended, or starved by others, has not listened.
const MAX_STEP: Duration = Duration::from_millis(250);

/// Time since the last report.
#[derive(Debug)]
pub struct Silence {
    listened: Duration,
    last: Instant,
}

impl Silence {
    /// The longest silence of a drive: it is asked for a sign of life several times within that.
    pub const MAX: Duration = Duration::from_secs(5);

    /// Begins.
    #[must_use]
    pub fn begin() -> Self {
        Self {
            listened: Duration::ZERO,
            last: Instant::now(),
        }
    }

    /// A report came, and the silence begins anew.
    pub fn end(&mut self) {
        *self = Self::begin();
    }

    /// True once it has lasted longer than [`MAX`](Self::MAX). Call it after every wait without a report.
    pub fn is_too_long(&mut self) -> bool {
        self.is_too_long_at(Instant::now())
    }

    fn is_too_long_at(&mut self, now: Instant) -> bool {
        self.listened += now.saturating_duration_since(self.last).min(MAX_STEP);
        self.last = now;
        self.listened > Self::MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_was_suspended_looks_at_what_has_arrived_before_it_calls_the_drive_silent() {
        let mut silence = Silence::begin();
        let mut now = silence.last;
        for _ in 0..3 {
            now += Duration::from_secs(60);
            assert!(!silence.is_too_long_at(now));
        }
        silence.end();
        assert_eq!(silence.listened, Duration::ZERO);
    }

    #[test]
    fn silence_that_was_listened_to_ends_after_its_limit() {
        let mut silence = Silence::begin();
        let begin = silence.last;
        let step = Duration::from_millis(50);
        let waits = (1..).find(|&waits| silence.is_too_long_at(begin + waits * step));
        assert_eq!(waits, Some(101));
    }
}
