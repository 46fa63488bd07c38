//! One estimate over a run: where it ended, how far it spread at the end, how far it still had to go.

use super::statistics::Statistics;

/// How far from the truth an estimate may be and count as settled: b̂ within this fraction, â
/// within this many 1/s.
pub(super) const SETTLED_B: f64 = 0.02;
pub(super) const SETTLED_A: f64 = 0.1;

/// An estimate that is at a bound for more than this part of the run's end stands there.
const AT_BOUND: f64 = 0.5;

/// One estimate over the run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// At the end; NaN, like all that follows from it, if the method then had none.
    pub last: f64,
    /// Mean over the last quarter.
    pub tail_mean: f64,
    /// Standard deviation over the last quarter.
    pub tail_std: f64,
    /// How far it still had to go when the run ended, judged from the means over the thirds of the
    /// last quarter; infinite if its steps did not get shorter.
    pub to_go: f64,
    /// The standard error of the estimate as it stands: what chance, the encoder and the way that it still had to go
    /// leave unknown; none where nothing is known of it.
    pub std_error: Option<f64>,
    /// Whether it stood at a bound for most of the last quarter: such a value is no result.
    pub at_bound: bool,
}

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
        if third.is_some() {
            self.samples += 1.0;
            self.at_bound += f64::from(u8::from(at_bound));
        }
        if !value.is_finite() {
            return;
        }
        if let Some(third) = third {
            self.tail.add(value);
            self.thirds[third].add(value);
        }
    }

    /// The estimate, with the tolerance within which it counts as being at rest.
    pub(super) fn estimate(
        &self,
        tolerance: impl Fn(f64) -> f64,
        std_error: Option<f64>,
    ) -> Estimate {
        if !self.last.is_finite() {
            return Estimate {
                last: f64::NAN,
                tail_mean: f64::NAN,
                tail_std: f64::NAN,
                to_go: f64::NAN,
                std_error: None,
                at_bound: false,
            };
        }
        let tail_mean = self.tail.mean().unwrap_or(self.last);
        let tail_std = self.tail.deviation().unwrap_or(0.0);
        let means = self.thirds.map(|third| third.mean().unwrap_or(self.last));
        Estimate {
            last: self.last,
            tail_mean,
            tail_std,
            to_go: distance_to_go(means, tolerance(tail_mean), tail_std),
            std_error,
            at_bound: self.ends_at_bound && self.at_bound > AT_BOUND * self.samples,
        }
    }
}

/// Where a sequence that has passed three equally spaced values will still go.
///
/// An exponential approach shortens its steps by a constant ratio; the steps to come then sum to
/// d₂²/(d₁ − d₂). A last step counts as none if it is below a quarter of the tolerance, or so small
/// beside the standard deviation over the whole stretch that noise explains it (a steady drift has
/// steps of 1.15 standard deviations). One that is no shorter than the step before is endless.
fn distance_to_go([first, second, third]: [f64; 3], tolerance: f64, deviation: f64) -> f64 {
    const STILL: f64 = 0.25;
    const NOISE: f64 = 0.7;
    let (before, last) = ((second - first).abs(), (third - second).abs());
    if last <= (STILL * tolerance).max(NOISE * deviation) {
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
    fn to_go(course: impl Fn(f64) -> f64, tolerance: f64) -> f64 {
        let mut tracked = Tracked::default();
        for k in 0..3000 {
            tracked.add(
                course(f64::from(k) / 3000.0),
                false,
                Some(k as usize / 1000),
            );
        }
        tracked.estimate(|_| tolerance, None).to_go
    }

    #[test]
    fn an_exponential_approach_is_seen_through() {
        // From 0 to 1 with a time constant of one stretch: e⁻¹ is left at its end.
        let left = to_go(|t| 1.0 - (-t).exp(), 0.1);
        assert!((0.3..0.6).contains(&left), "{left}");
    }

    #[test]
    fn a_steady_drift_is_endless_and_noise_is_no_drift() {
        assert!(to_go(|t| t, 0.1).is_infinite());
        let noise = to_go(|t| 0.3 * (1234.5 * t).sin(), 0.1);
        assert!(noise < 1e-12, "{noise}");
        assert!(to_go(|t| 0.01 * t, 0.1) < 1e-12, "far below the tolerance");
    }
}
