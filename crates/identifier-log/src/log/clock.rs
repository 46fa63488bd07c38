//! An even clock beside the time stamps of a log.

/// The place of a row's time stamp on the clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Tick {
    /// It belongs to the sample this number of samples after the last row's.
    After(u32),
    /// It is no later than the last row's.
    Back,
    /// Less than half a sample after the last row: two rows would be one sample.
    TooEarly,
}

/// An even clock that follows the time stamps of a log. The samples are assumed even, however much their stamps jitter.
/// Those of a drive that a computer logs are even.
///
/// A stamp belongs to the sample that it is within 0.6 sample times of. The clock is the mean of the stamps so far, and
/// later that of the last 32. It follows a rate that is slightly off and averages the jitter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ticks {
    sample_time: f64,
    /// The last stamp, s, and where the clock has it.
    last: f64,
    even: f64,
    /// Rows since the clock began.
    rows: f64,
    /// Sum of squares, and the largest, of the deviations of the stamps, samples.
    squares: f64,
    largest: f64,
}

impl Ticks {
    const MAX_DEVIATION: f64 = 0.6;
    const MAX_AVERAGED: f64 = 32.0;

    /// Begins with a stamp, s.
    pub(super) fn new(sample_time: f64, stamp: f64) -> Self {
        Self {
            sample_time,
            last: stamp,
            even: stamp,
            rows: 1.0,
            squares: 0.0,
            largest: 0.0,
        }
    }

    /// The next stamp, s. The clock stops for a stamp that is back or too early.
    pub(super) fn tick(&mut self, stamp: f64) -> Tick {
        // Samples since the last tick of the clock, not whole where the stamps jitter.
        let later = (stamp - self.even) / self.sample_time;
        if stamp <= self.last {
            return Tick::Back;
        }
        let samples = if (1.0 - later).abs() <= Self::MAX_DEVIATION {
            1.0
        } else {
            later.round()
        };
        if samples.is_nan() || samples < 1.0 {
            return Tick::TooEarly;
        }
        let off = later - samples;
        self.squares += off * off;
        self.largest = self.largest.max(off.abs());
        self.rows += 1.0;
        self.last = stamp;
        self.even += self.sample_time * (samples + off / self.rows.min(Self::MAX_AVERAGED));
        Tick::After(samples.min(f64::from(u32::MAX)) as u32)
    }

    /// Deviation of the stamps from the clock.
    pub(super) fn jitter(&self) -> Jitter {
        Jitter {
            squares: self.squares,
            rows: self.rows,
            largest: self.largest,
        }
    }
}

/// Deviation of the time stamps of a log from an even clock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jitter {
    squares: f64,
    rows: f64,
    largest: f64,
}

impl Jitter {
    /// Root mean square, part of a sample.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.squares / self.rows.max(1.0)).sqrt()
    }

    /// The largest, part of a sample.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Combined with that of another part of the log.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            rows: self.rows + other.rows,
            largest: self.largest.max(other.largest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Tick, Ticks};

    /// Numbers from −1 to 1 in no order.
    fn noise(k: u32) -> f64 {
        let k = u64::from(k);
        let mixed = (k ^ (k >> 7)).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11;
        (mixed as f64) / (1_u64 << 52) as f64 - 1.0
    }

    #[test]
    fn jitter_of_any_kind_below_half_a_sample_loses_no_sample() {
        for part in [0.0, 0.1, 0.2, 0.29] {
            let stamp = |k: u32| 1e-3 * (f64::from(k) + part * noise(k));
            let mut clock = Ticks::new(1e-3, stamp(0));
            let even = (1..100_000).all(|k| clock.tick(stamp(k)) == Tick::After(1));
            assert!(even, "{part}");
            let rms = clock.jitter().rms();
            assert!(
                (rms / (part / 3_f64.sqrt()) - 1.0).abs() < 0.05 || part == 0.0,
                "{rms}"
            );
            // At first the clock is no truer than the stamps themselves.
            assert!(clock.jitter().largest() < 2.0 * part + 1e-6);
        }
    }

    #[test]
    fn a_rate_that_is_one_per_cent_off_is_followed() {
        for rate in [0.99, 1.01] {
            let mut clock = Ticks::new(1e-3, 5.0);
            assert!((1..10_000).all(|k| {
                let stamp = 5.0 + 1e-3 * rate * f64::from(k);
                clock.tick(stamp) == Tick::After(1)
            }));
        }
        let mut clock = Ticks::new(1e-3, 0.0);
        let ticks: Vec<_> = (1..1000)
            .map(|k| clock.tick(1.05e-3 * f64::from(k)))
            .collect();
        assert!(ticks.contains(&Tick::After(2)));
    }

    #[test]
    fn missing_samples_and_stamps_that_go_back_are_detected() {
        let mut clock = Ticks::new(0.01, 0.0);
        assert_eq!(clock.tick(0.0101), Tick::After(1));
        assert_eq!(clock.tick(0.0495), Tick::After(4));
        assert_eq!(clock.tick(0.0495), Tick::Back);
        assert_eq!(clock.tick(0.03), Tick::Back);
        assert_eq!(clock.tick(0.0520), Tick::TooEarly);
        assert_eq!(clock.tick(0.06), Tick::After(1));
    }
}
