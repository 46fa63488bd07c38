//! Uneven sampling instants: a position that was read too early or too late is off by the way until then, so that its noise
//! grows with the speed.

use identifier_core::identification::{Fitted, Fitter};

use super::tournament::{Entered, MIN_GAIN};
use crate::verdict::Cause;

/// Parts of the samples by their speed, and the fewest samples of a part.
const PARTS: usize = 10;
const MIN_SAMPLES: usize = 20;

/// Samples to either side over which a speed is measured.
const REACH: usize = 4;

/// The least speed, counts/sample: below it the rounding of successive positions is not independent.
const MIN_SPEED: f64 = 1.0;

/// The part of what any dependence on the speed explains that its square must explain.
const MIN_SHARE: f64 = 0.8;

/// The correlation of successive innovations up to which they are noise: a vibration's go together.
const MAX_CORRELATION: f64 = 0.2;

/// The noise at the highest speeds over that at none, as variances.
const MIN_RATIO: f64 = 1.5;

/// Sampling instants that are uneven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Jitter {
    /// Their deviation, samples.
    pub(super) deviation: f64,
    /// Gain in −2 ln L over a noise that is the same at every speed.
    gain: f64,
}

/// Two successive samples that move.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Noise {
    /// Square of the speed.
    speed: f64,
    /// Half the square of the difference of their innovations, in which hardly any of a model error is left.
    noise: f64,
    /// The product of their innovations.
    product: f64,
}

/// Samples of about the same speed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    samples: f64,
    /// Mean squares of speed and noise.
    speed: f64,
    noise: f64,
}

impl Jitter {
    /// Of a fitted record; none where the noise does not grow with the speed's square.
    pub(super) fn find(fitter: &Fitter<'_>, fitted: &Fitted) -> Option<Self> {
        let mut noises = noises(fitter, fitted);
        let sum = |of: &dyn Fn(&Noise) -> f64| noises.iter().map(of).sum::<f64>();
        let correlation = sum(&|one| one.product) / sum(&|one| one.noise + one.product);
        if correlation.abs() > MAX_CORRELATION {
            return None;
        }
        let parts = parts(&mut noises)?;
        Self::of(&parts).filter(|jitter| jitter.gain >= MIN_GAIN)
    }

    fn of(parts: &[Part]) -> Option<Self> {
        // Weighted least squares: the variance of a variance is its square twice over.
        let mut sums = [0.0; 5];
        for part in parts {
            let weight = part.samples / part.noise.powi(2);
            let terms = [
                1.0,
                part.speed,
                part.speed * part.speed,
                part.noise,
                part.noise * part.speed,
            ];
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += weight * term;
            }
        }
        let [one, x, xx, y, xy] = sums;
        let slope = (one * xy - x * y) / (one * xx - x * x);
        let rest = ((y - slope * x) / one).max(0.0);
        let fastest = parts.last()?.speed;
        if slope.is_nan() || slope * fastest < (MIN_RATIO - 1.0) * rest {
            return None;
        }
        let minus_two_log_likelihood = |variance: &dyn Fn(&Part) -> f64| {
            let of_part = |part: &Part| {
                let variance = variance(part);
                part.samples * (variance.ln() + part.noise / variance)
            };
            parts.iter().map(of_part).sum::<f64>()
        };
        let samples: f64 = parts.iter().map(|part| part.samples).sum();
        let mean = parts
            .iter()
            .map(|part| part.samples * part.noise)
            .sum::<f64>()
            / samples;
        let constant = minus_two_log_likelihood(&|_| mean);
        let gain = constant - minus_two_log_likelihood(&|part| rest + slope * part.speed);
        let most = constant - minus_two_log_likelihood(&|part| part.noise);
        (gain > MIN_SHARE * most).then(|| Self {
            deviation: slope.sqrt(),
            gain,
        })
    }

    /// As an effect that the record shows.
    pub(super) const fn entered(&self) -> Entered {
        Entered::certain(Cause::Jitter, self.gain)
    }
}

/// All pairs of successive samples that move, each sample in one of them.
fn noises(fitter: &Fitter<'_>, fitted: &Fitted) -> Vec<Noise> {
    let record = fitter.record;
    let mut noises = Vec::new();
    let mut last: Option<(usize, f64)> = None;
    fitter
        .pass(&fitted.values, fitted.horizon)
        .run(&fitted.values, &[], &mut |row| {
            let own = row.innovation / row.variance.sqrt();
            let before = last
                .take()
                .filter(|(sample, _)| row.sample - sample <= record.stride);
            let Some((_, before)) = before else {
                last = Some((row.sample, own));
                return;
            };
            let ends = [row.sample.checked_sub(REACH), row.sample.checked_add(REACH)];
            let [Some(from), Some(to)] =
                ends.map(|end| end.and_then(|end| record.positions.get(end)))
            else {
                return;
            };
            let speed = ((to - from) / (2 * REACH) as f64).abs();
            if speed >= MIN_SPEED {
                noises.push(Noise {
                    speed: speed * speed,
                    noise: 0.5 * (own - before).powi(2),
                    product: own * before,
                });
            }
        });
    noises
}

/// Their parts by the speed.
fn parts(noises: &mut [Noise]) -> Option<Vec<Part>> {
    noises.sort_unstable_by(|one, other| one.speed.total_cmp(&other.speed));
    let length = noises.len() / PARTS;
    if length < MIN_SAMPLES {
        return None;
    }
    let part = |samples: &[Noise]| {
        let count = samples.len() as f64;
        let mean = |of: &dyn Fn(&Noise) -> f64| samples.iter().map(of).sum::<f64>() / count;
        Part {
            samples: count,
            speed: mean(&|one| one.speed),
            noise: mean(&|one| one.noise).max(f64::MIN_POSITIVE),
        }
    };
    Some(noises.chunks_exact(length).map(part).collect())
}
