//! One estimate over a run: its final value, its spread at the end, and the distance still to go.

use identifier_log::analysis::Statistics;
use identifier_log::result::Estimate;
use identifier_log::verdict::State;

/// The distances from the truth within which an estimate is settled: b̂ within this fraction, â within this value in
/// 1/s.
pub(super) const SETTLED_B: f64 = 0.02;
pub(super) const SETTLED_A: f64 = 0.1;

/// An estimate that is at a bound for more than this part of the run's end counts as being there.
const AT_BOUND: f64 = 0.5;

/// Gathers an [`Estimate`] from its values, sample by sample.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tracked {
    pub(super) last: f64,
    tail: Statistics,
    thirds: [Statistics; 3],
    samples: f64,
    at_bound: f64,
    ends_at_bound: bool,
}

impl Tracked {
    /// Takes in a value; over the tail, in which third of it.
    pub(super) fn add(&mut self, value: f64, at_bound: bool, third: Option<usize>) {
        self.last = value;
        self.ends_at_bound = at_bound;
        let Some(third) = third else { return };
        self.samples += 1.0;
        self.at_bound += f64::from(u8::from(at_bound));
        if value.is_finite() {
            self.tail.add(value);
            self.thirds[third].add(value);
        }
    }

    /// The estimate, with the tolerance within which it counts as being at rest. Its standard error is unknown here,
    /// and its value is that of the end.
    pub(super) fn estimate(&self, tolerance: impl Fn(f64) -> f64) -> Estimate {
        let last = self.last;
        let unknown = Estimate {
            last: f64::NAN,
            tail_mean: f64::NAN,
            tail_std: f64::NAN,
            std_error: None,
            state: State::Unknown,
            at_bound: false,
            unit: "",
            value: f64::NAN,
            remaining_change: f64::NAN,
            is_estimated: false,
        };
        if !last.is_finite() {
            return unknown;
        }
        let tail_mean = self.tail.mean().unwrap_or(last);
        let tail_std = self.tail.deviation().unwrap_or(0.0);
        let means = self.thirds.map(|third| third.mean().unwrap_or(last));
        Estimate {
            last,
            tail_mean,
            tail_std,
            at_bound: self.ends_at_bound && self.at_bound > AT_BOUND * self.samples,
            value: last,
            remaining_change: distance_to_go(means, tolerance(tail_mean), tail_std),
            ..unknown
        }
    }
}

/// Where a sequence that has passed three equally spaced values will still go.
///
/// An exponential approach shortens its steps by a constant ratio. The remaining steps then sum to d₂²/(d₁ − d₂). A
/// last step counts as none if it is below a quarter of the tolerance. The same holds if it is so small beside the
/// standard deviation over the whole segment that noise explains it. A steady drift has steps of 1.15 standard
/// deviations. One that is no shorter than the step before is endless.
fn distance_to_go([first, second, third]: [f64; 3], tolerance: f64, deviation: f64) -> f64 {
    const STILL_STEP: f64 = 0.25;
    const NOISE: f64 = 0.7;
    let (before, last) = ((second - first).abs(), (third - second).abs());
    if last <= (STILL_STEP * tolerance).max(NOISE * deviation) {
        0.0
    } else if last < before {
        last * last / (before - last)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::Tracked;

    /// The distance that a course over the last quarter still has to go.
    fn remaining_change(course: impl Fn(f64) -> f64, tolerance: f64) -> f64 {
        let mut tracked = Tracked::default();
        for k in 0..3000 {
            let value = course(f64::from(k) / 3000.0);
            tracked.add(value, false, Some(k as usize / 1000));
        }
        tracked.estimate(|_| tolerance).remaining_change
    }

    #[test]
    fn an_exponential_approach_is_seen_through() {
        // From 0 to 1 with a time constant of one stretch: e⁻¹ is left at its end.
        let left = remaining_change(|t| 1.0 - (-t).exp(), 0.1);
        assert!((0.3..0.6).contains(&left), "{left}");
    }

    #[test]
    fn a_steady_drift_is_endless_and_noise_is_no_drift() {
        assert!(remaining_change(|t| t, 0.1).is_infinite());
        let noise = remaining_change(|t| 0.3 * (1234.5 * t).sin(), 0.1);
        assert!(noise < 1e-12, "{noise}");
        let slow = remaining_change(|t| 0.01 * t, 0.1);
        assert!(slow < 1e-12, "far below the tolerance");
    }
}
