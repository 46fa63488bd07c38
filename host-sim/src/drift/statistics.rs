use super::{Compared, SIGNALS};

/// Gathers the differences of a run.
#[derive(Debug, Clone)]
pub struct Differences {
    tail_from: f64,
    held: [[Sums; SIGNALS.len()]; 2],
    finite: bool,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: f64,
    size: f64,
    square: f64,
    sum: f64,
    max: f64,
}

impl Differences {
    /// For a run of this duration, s.
    #[must_use]
    pub fn lasting(duration: f64) -> Self {
        Self {
            tail_from: 0.75 * duration,
            held: [[Sums::default(); SIGNALS.len()]; 2],
            finite: true,
        }
    }

    /// Takes in a sample.
    pub fn add(&mut self, compared: &Compared) {
        let [reference, others @ ..] = &compared.signals;
        for (sums, other) in self.held.iter_mut().zip(others) {
            for (sum, signal) in sums.iter_mut().zip(SIGNALS) {
                let [exact, value] = [reference, other].map(signal.value);
                let difference = value - exact;
                self.finite &= difference.is_finite();
                sum.max = sum.max.max(difference.abs());
                if compared.time >= self.tail_from {
                    sum.count += 1.0;
                    sum.size += exact * exact;
                    sum.square += difference * difference;
                    sum.sum += difference;
                }
            }
        }
    }

    /// The result of `samples` samples.
    #[must_use]
    pub fn result(&self, samples: u64) -> DriftResult {
        let [f32, fixed] = self.held.map(differences);
        DriftResult {
            samples,
            all_finite: self.finite,
            f32,
            fixed,
        }
    }
}

fn differences(held: [Sums; SIGNALS.len()]) -> Vec<Difference> {
    let signals = held.iter().zip(SIGNALS);
    let differences = signals.map(|(sums, signal)| {
        let count = sums.count.max(1.0);
        Difference {
            name: signal.name,
            unit: signal.unit,
            size: (sums.size / count).sqrt(),
            rms: (sums.square / count).sqrt(),
            mean: sums.sum / count,
            max: sums.max,
        }
    });
    differences.collect()
}

/// Differences of number formats from double precision.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftResult {
    /// Samples run.
    pub samples: u64,
    /// True if every value was finite.
    pub all_finite: bool,
    /// Differences in single precision.
    pub f32: Vec<Difference>,
    /// Differences in fixed point.
    pub fixed: Vec<Difference>,
}

/// Difference of a signal of a format from that of double precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The signal's name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Root mean square of the signal itself over the last quarter, in double precision.
    pub size: f64,
    /// Mean of the difference over the last quarter.
    pub mean: f64,
    /// Its root mean square over the last quarter.
    pub rms: f64,
    /// Its largest magnitude over the whole run.
    pub max: f64,
}

impl Difference {
    /// 20 log₁₀ of the signal's root mean square over that of the difference; none without either.
    #[must_use]
    pub fn signal_to_noise(&self) -> Option<f64> {
        let has_both = self.rms > 0.0 && self.size > 0.0;
        has_both.then(|| 20.0 * (self.size / self.rms).log10())
    }
}
