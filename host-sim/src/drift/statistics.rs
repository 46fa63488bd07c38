use serde::Serialize;

use super::{Compared, Signals};
use crate::scenario::Arithmetic;

/// How far a signal of a format is from that of double precision.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Difference {
    /// The signal's name.
    #[serde(rename = "signal")]
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

/// What is held against double precision: name, unit and value.
type Held = (&'static str, &'static str, fn(&Signals) -> f64);

const SIGNALS: [Held; 7] = [
    ("velocity", "rad/s", |signals| signals.velocity),
    ("command", "command units", |signals| signals.command),
    ("output error", "rad", |signals| signals.output_error),
    ("a", "1/s", |signals| signals.estimates.a),
    ("b", "rad/s² per command unit", |signals| {
        signals.estimates.b
    }),
    ("coulomb", "rad/s²", |signals| signals.estimates.coulomb),
    ("load", "rad/s²", |signals| signals.estimates.load),
];

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

impl Difference {
    /// 20 log₁₀ of the signal's root mean square over that of the difference; none without either.
    #[must_use]
    pub fn signal_to_noise(&self) -> Option<f64> {
        let has_both = self.rms > 0.0 && self.size > 0.0;
        has_both.then(|| 20.0 * (self.size / self.rms).log10())
    }
}

impl Differences {
    /// For a run that lasts so long, s.
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
            for (sum, (_, _, of)) in sums.iter_mut().zip(SIGNALS) {
                let (exact, difference) = (of(reference), of(other) - of(reference));
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

    /// Whether no value was infinite or no number.
    #[must_use]
    pub fn all_finite(&self) -> bool {
        self.finite
    }

    /// The differences of a format; empty for double precision itself.
    #[must_use]
    pub fn of(&self, format: Arithmetic) -> Vec<Difference> {
        let place = match format {
            Arithmetic::F64 => return Vec::new(),
            Arithmetic::F32 => 0,
            Arithmetic::Fixed => 1,
        };
        self.held[place]
            .iter()
            .zip(SIGNALS)
            .map(|(sums, (name, unit, _))| {
                let count = sums.count.max(1.0);
                Difference {
                    name,
                    unit,
                    size: (sums.size / count).sqrt(),
                    rms: (sums.square / count).sqrt(),
                    mean: sums.sum / count,
                    max: sums.max,
                }
            })
            .collect()
    }
}
