//! Uneven sampling instants. A position read too early or too late is wrong by the distance moved meanwhile, so its
//! noise grows with speed.

use crate::fit::{Fitted, RecordFitter};

use super::effect_selection::MIN_GAIN;
use super::model::Entered;
use crate::cause::Cause;

/// Number of speed classes, up to twice a large speed, and the fewest samples of a class and classes.
const PARTS: usize = 10;
const FASTEST: f64 = 2.0;
const MIN_SAMPLES: f64 = 20.0;
const MIN_PARTS: usize = 3;

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

/// Pairs of successive samples that move at about the same speed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Part {
    samples: f64,
    /// Mean squares of the speed, and of half the difference of two innovations. That difference contains almost no
    /// model error.
    speed: f64,
    noise: f64,
    /// Mean product of the innovations.
    product: f64,
}

impl Part {
    fn mean(self) -> Self {
        let per_sample = 1.0 / self.samples;
        Self {
            samples: self.samples,
            speed: self.speed * per_sample,
            noise: (self.noise * per_sample).max(f64::MIN_POSITIVE),
            product: self.product * per_sample,
        }
    }
}

impl Jitter {
    /// The jitter of a fitted record. None if the noise does not grow with the speed's square.
    pub(super) fn find(fitter: &RecordFitter<'_>, fitted: &Fitted) -> Option<Self> {
        let parts: Vec<Part> = parts(fitter, fitted)
            .into_iter()
            .filter(|part| part.samples >= MIN_SAMPLES)
            .map(Part::mean)
            .collect();
        let (mut products, mut squares) = (0.0, 0.0);
        for part in &parts {
            products += part.samples * part.product;
            squares += part.samples * (part.noise + part.product);
        }
        if parts.len() < MIN_PARTS || products.abs() > MAX_CORRELATION * squares {
            return None;
        }
        Self::of(&parts).filter(|jitter| jitter.gain >= MIN_GAIN)
    }

    fn of(parts: &[Part]) -> Option<Self> {
        let (mut one, mut x, mut xx, mut y, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut samples, mut squares) = (0.0, 0.0);
        for part in parts {
            // The variance of a variance is its square twice over.
            let weight = part.samples / (part.noise * part.noise);
            one += weight;
            x += weight * part.speed;
            xx += weight * part.speed * part.speed;
            y += weight * part.noise;
            xy += weight * part.noise * part.speed;
            samples += part.samples;
            squares += part.samples * part.noise;
        }
        let slope = (one * xy - x * y) / (one * xx - x * x);
        let rest = ((y - slope * x) / one).max(0.0);
        let fastest = parts.last()?.speed;
        if slope.is_nan() || slope * fastest < (MIN_RATIO - 1.0) * rest {
            return None;
        }
        let mean = squares / samples;
        let (mut gain, mut most) = (0.0, 0.0);
        for part in parts {
            let constant = mean.ln() + part.noise / mean;
            let growing = rest + slope * part.speed;
            gain += part.samples * (constant - growing.ln() - part.noise / growing);
            most += part.samples * (constant - part.noise.ln() - 1.0);
        }
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

/// The sums over pairs of successive samples that move, by their speed. Each sample is in one pair.
fn parts(fitter: &RecordFitter<'_>, fitted: &Fitted) -> [Part; PARTS] {
    let record = fitter.record;
    let per_part = PARTS as f64 / (FASTEST * fitter.statistics.velocity);
    let mut parts = [Part::default(); PARTS];
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
            if let Some(part) = parts.get_mut((speed * per_part) as usize)
                && speed >= MIN_SPEED
            {
                part.samples += 1.0;
                part.speed += speed * speed;
                part.noise += 0.5 * (own - before).powi(2);
                part.product += own * before;
            }
        });
    parts
}
