use std::time::{Duration, Instant};

/// How far the drive's time may lag behind the clock, s. What is more is left out: who stops a process or
/// closes a notebook does not want to see what it missed.
const LONGEST_LAG: f64 = 0.1;

/// The drive's time beside the clock on the wall, s.
pub(super) struct Clock {
    begun: Instant,
    /// What was left out.
    missed: f64,
    now: f64,
    next: f64,
}

impl Clock {
    pub(super) fn start() -> Self {
        Self {
            begun: Instant::now(),
            missed: 0.0,
            now: 0.0,
            next: 0.0,
        }
    }

    /// Looks at the clock on the wall.
    pub(super) fn look(&mut self) {
        self.now = self.begun.elapsed().as_secs_f64() - self.missed;
        let lag = self.now - self.next - LONGEST_LAG;
        if lag > 0.0 {
            self.missed += lag;
            self.now -= lag;
        }
    }

    /// Whether a sample is due.
    pub(super) fn is_due(&self) -> bool {
        self.next <= self.now
    }

    /// A sample was done; the next comes after its sample time, s.
    pub(super) fn advance(&mut self, sample_time: f64) {
        self.next += sample_time;
    }

    /// Until the next sample, as of the last look.
    pub(super) fn left(&self) -> Duration {
        Duration::from_secs_f64((self.next - self.now).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_stopped_program_missed_is_left_out() {
        const SAMPLE_TIME: f64 = 1e-3;
        let mut clock = Clock::start();
        clock.missed = -10.0;
        clock.look();
        let mut samples = 0;
        while clock.is_due() {
            clock.advance(SAMPLE_TIME);
            samples += 1;
        }
        let most = LONGEST_LAG / SAMPLE_TIME;
        assert!(
            (most - 2.0..=most + 2.0).contains(&f64::from(samples)),
            "{samples}"
        );
        assert!(clock.left() <= Duration::from_secs_f64(SAMPLE_TIME));
    }
}
