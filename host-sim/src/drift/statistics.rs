use super::{Compared, SIGNALS};
use crate::result::{Difference, DriftResult};

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
