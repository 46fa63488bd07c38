use std::time::{Duration, Instant};

/// Longest lag of the drive's time behind the real time, s. More is skipped: a process that was stopped does not
/// make up for the missed time.
const MAX_LAG: f64 = 0.1;

/// The drive's time, which follows the real time at a pace.
#[derive(Debug)]
pub struct Clock {
    begin: Instant,
    /// Drive's seconds per second of real time.
    pace: f64,
    /// Skipped, s.
    skipped: f64,
    now: f64,
    next_sample: f64,
}

impl Clock {
    /// Starts a clock at `pace` seconds per second of real time.
    #[must_use]
    pub fn at_pace(pace: f64) -> Self {
        Self {
            begin: Instant::now(),
            pace,
            skipped: 0.0,
            now: 0.0,
            next_sample: 0.0,
        }
    }

    /// Reads the real time.
    pub(super) fn update(&mut self) {
        self.now = self.pace * self.begin.elapsed().as_secs_f64() - self.skipped;
        let excess = self.now - self.next_sample - MAX_LAG;
        if excess > 0.0 {
            self.skipped += excess;
            self.now -= excess;
        }
    }

    /// True if a sample is pending.
    pub(super) fn is_due(&self) -> bool {
        self.next_sample <= self.now
    }

    /// Advances the clock by a sample; the next follows after its sample time, s.
    pub(super) fn advance(&mut self, sample_time: f64) {
        self.next_sample += sample_time;
    }

    /// Real time until the next sample, as of the last update.
    pub(super) fn left(&self) -> Duration {
        Duration::from_secs_f64((self.next_sample - self.now).max(0.0) / self.pace)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_that_a_stopped_program_missed_is_skipped() {
        const SAMPLE_TIME: f64 = 1e-3;
        let mut clock = Clock::at_pace(1.0);
        clock.skipped = -10.0;
        clock.update();
        let mut samples = 0;
        while clock.is_due() {
            clock.advance(SAMPLE_TIME);
            samples += 1;
        }
        let most = MAX_LAG / SAMPLE_TIME;
        assert!(
            (most - 2.0..=most + 2.0).contains(&f64::from(samples)),
            "{samples}"
        );
        assert!(clock.left() <= Duration::from_secs_f64(SAMPLE_TIME));
    }
}
