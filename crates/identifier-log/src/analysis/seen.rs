//! A log beside the model that was identified from it, as one sees whether the model is right.

use std::f64::consts::TAU;

use identifier_core::parameters::Unknown;
use log_fit::Logged;

use super::whole_record::WholeRecord;
use crate::scaled_recording::ScaledRecording;
use crate::scenario::Options;

/// The residuals of a model over its log, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// The measured position minus that of the model for every sample, rad. The model runs free in windows.
    pub errors: Vec<f64>,
    /// Length of a window, s.
    pub window: f64,
    /// A count, rad.
    pub count: f64,
    /// Deviation of the errors, rad.
    pub deviation: f64,
    /// Deviation of the model's prediction of the next sample, rad.
    pub innovation: f64,
    /// Correlation of that from sample to sample.
    pub correlation: f64,
    /// The friction by velocity.
    pub friction: Vec<Braking>,
    /// The response by frequency, from the command to the velocity.
    pub response: Vec<FoundResponse>,
}

/// Friction at a velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Braking {
    /// Rad/s.
    pub velocity: f64,
    /// The mean of the log, rad/s².
    pub measured: f64,
    /// The deviation of that mean, rad/s².
    pub deviation: f64,
    /// The model's, rad/s².
    pub model: f64,
}

/// The response at a frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundResponse {
    /// Rad/s.
    pub frequency: f64,
    /// Rad/s per command unit, of the log and of the model that was moved by the same command.
    pub measured: f64,
    /// See `measured`.
    pub model: f64,
    /// The part of the log's velocity that is coherent with the command, 0 to 1.
    pub coherence: f64,
}

impl Seen {
    /// The residuals over the samples that a fit explains; none if the model diverges in them.
    #[must_use]
    pub fn new(scenario: &Options, samples: &[Logged], whole: &WholeRecord) -> Option<Self> {
        let ScaledRecording { recording, scale } = ScaledRecording::new(scenario, samples);
        let count = scale.position;
        let course = whole.found.course(&recording)?;
        let errors: Vec<f64> = course.errors.iter().map(|error| count * error).collect();
        let known = errors.iter().filter(|error| error.is_finite());
        let innovation = count * course.innovation;
        let motion = Motion {
            samples,
            sample_time: scenario.sample_time(),
        };
        Some(Self {
            window: course.window as f64 * scenario.sample_time(),
            count,
            deviation: mean(known.map(|error| error * error)).sqrt(),
            innovation,
            correlation: course.correlation,
            friction: motion.friction(whole, innovation),
            response: motion.response(&errors),
            errors,
        })
    }
}

/// Samples of a log.
#[derive(Clone, Copy)]
struct Motion<'a> {
    samples: &'a [Logged],
    /// S.
    sample_time: f64,
}

impl Motion<'_> {
    /// Means by velocity of what brakes: b u + d and the forces of the angle less the acceleration. The second
    /// difference of positions is the mean acceleration with triangular weights. The command is averaged with the same
    /// weights.
    fn friction(self, whole: &WholeRecord, noise: f64) -> Vec<Braking> {
        /// Part of the usual acceleration that the noise of a second difference has at most, and longest span, s.
        const NOISE: f64 = 0.05;
        const LONGEST: f64 = 0.2;
        const BINS: usize = 40;
        const FEWEST: usize = 5;
        let WholeRecord { servo, terms, .. } = whole;
        let term = |unknown: Unknown| {
            let found = terms.iter().find(|term| term.unknown == unknown);
            found.map_or(0.0, |term| term.value)
        };
        let fades = whole.low_speed_velocity.unwrap_or(f64::INFINITY);
        let time = self.sample_time;
        let all = self.samples;
        let usual = servo.b * (mean(all.iter().map(|one| one.command * one.command))).sqrt();
        let span = (6.0_f64.sqrt() * noise / (NOISE * usual)).sqrt();
        let span = (span.min(LONGEST) / time).ceil() as usize;
        let span = span.min(all.len() / 20).max(1);
        let late = (term(Unknown::Delay) / time).round().max(0.0) as usize;
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut centre = span + late;
        while centre + span < all.len() {
            let part = &all[centre - span - late..=centre + span];
            let here = centre;
            centre += (span / 2).max(1);
            if part[1..].iter().any(|one| one.begins) {
                continue;
            }
            let [before, now, after] = [here - span, here, here + span].map(|at| all[at].position);
            let step = span as f64 * time;
            let velocities = [(now - before) / step, (after - now) / step];
            // In a turn there is friction of both signs.
            if velocities[0] * velocities[1] <= 0.0 {
                continue;
            }
            let weighted = (0..2 * span).map(|k| {
                // From each sample to the next the command is held.
                let from = k as f64 - span as f64 + 0.5;
                let weight = 1.0 - from.abs() / span as f64;
                weight * all[here + k - span - late].command
            });
            let command = weighted.sum::<f64>() / span as f64;
            let angle =
                term(Unknown::GravitySine) * now.sin() + term(Unknown::GravityCosine) * now.cos();
            let acceleration = (velocities[1] - velocities[0]) / step;
            let velocity = 0.5 * (velocities[0] + velocities[1]);
            points.push([
                velocity,
                servo.b * command + servo.load + angle - acceleration,
            ]);
        }
        points.sort_unstable_by(|one, other| one[0].total_cmp(&other[0]));
        let [low, high] = match (points.first(), points.last()) {
            (Some(first), Some(last)) => [first[0], last[0]],
            _ => return Vec::new(),
        };
        let width = (high - low) / BINS as f64;
        let bins = points.chunk_by(|one, other| {
            let bin = |point: &[f64; 2]| ((point[0] - low) / width) as usize;
            bin(one) == bin(other) && one[0] * other[0] > 0.0
        });
        bins.filter(|bin| bin.len() >= FEWEST)
            .map(|bin| {
                let of = |place: usize| mean(bin.iter().map(|point| point[place]));
                let [velocity, measured] = [of(0), of(1)];
                let scatter = mean(bin.iter().map(|point| (point[1] - measured).powi(2)));
                let sign = velocity.signum();
                Braking {
                    velocity,
                    measured,
                    deviation: (scatter / bin.len() as f64).sqrt(),
                    model: servo.a * velocity
                        + term(Unknown::Asymmetry) * velocity.abs()
                        + servo.coulomb * sign
                        + term(Unknown::LowSpeed) * (-(velocity / fades).powi(2)).exp() * sign,
                }
            })
            .collect()
    }

    /// The response from the command to the velocity by windows of a cosine. One is that of the log, the other that of
    /// its model under the same commands.
    fn response(self, errors: &[f64]) -> Vec<FoundResponse> {
        const FREQUENCIES: usize = 30;
        const WINDOWS: usize = 16;
        /// Steps of a window, which are rows, or several together where a twelfth of the log has more.
        const LENGTH: [usize; 2] = [64, 2048];
        let each = (self.samples.len() / 12).div_ceil(LENGTH[1]).max(1);
        let time = each as f64 * self.sample_time;
        // Where a window begins the model is where the servo is.
        let left = |at: usize| Some(errors[at]).filter(|error| error.is_finite());
        let steps: Vec<Option<[f64; 3]>> = (1..self.samples.len() / each)
            .map(|step| {
                let (from, to) = ((step - 1) * each, step * each);
                let rows = &self.samples[from..=to];
                let moved = rows[each].position - rows[0].position;
                let model = moved - left(to).unwrap_or(0.0) + left(from).unwrap_or(0.0);
                let command = mean(rows[..each].iter().map(|row| row.command));
                let is_one = rows[1..].iter().all(|row| !row.begins);
                is_one.then_some([command, moved / time, model / time])
            })
            .collect();
        let length = (steps.len() / 12).clamp(LENGTH[0], LENGTH[1]);
        let apart = (length / 2).max(steps.len().saturating_sub(length) / WINDOWS);
        let windows: Vec<Vec<[f64; 3]>> = (0..)
            .map(|k| k * apart)
            .take_while(|first| first + length <= steps.len())
            .filter_map(|first| steps[first..first + length].iter().copied().collect())
            .collect();
        if windows.len() < 4 {
            return Vec::new();
        }
        let lowest = 3.0 * TAU / length as f64;
        let ratio = (0.8 * std::f64::consts::PI / lowest).powf(1.0 / (FREQUENCIES - 1) as f64);
        (0..FREQUENCIES)
            .map(|k| {
                let frequency = lowest * ratio.powi(k as i32);
                let mut sums = [0.0_f64; 6];
                for window in &windows {
                    let mut spectra = [[0.0_f64; 2]; 3];
                    for (place, pair) in window.windows(2).enumerate() {
                        // Velocities are far larger at low frequencies, and would leak from there: their changes are not.
                        let [[_, v, m], [command, next_v, next_m]] = [pair[0], pair[1]];
                        let values = [command, next_v - v, next_m - m];
                        let weight = 1.0 - (TAU * place as f64 / length as f64).cos();
                        let (sine, cosine) = (frequency * place as f64).sin_cos();
                        for (spectrum, value) in spectra.iter_mut().zip(values) {
                            spectrum[0] += weight * value * cosine;
                            spectrum[1] -= weight * value * sine;
                        }
                    }
                    let [u, v, m] = spectra;
                    let cross =
                        |a: [f64; 2]| [a[0] * u[0] + a[1] * u[1], a[1] * u[0] - a[0] * u[1]];
                    let power = |a: [f64; 2]| a[0] * a[0] + a[1] * a[1];
                    let [of_log, of_model] = [cross(v), cross(m)];
                    let own = [
                        power(u),
                        power(v),
                        of_log[0],
                        of_log[1],
                        of_model[0],
                        of_model[1],
                    ];
                    for (sum, one) in sums.iter_mut().zip(own) {
                        *sum += one;
                    }
                }
                let [uu, vv, x, y, p, q] = sums;
                let change = 2.0 * (0.5 * frequency).sin();
                FoundResponse {
                    frequency: frequency / time,
                    measured: x.hypot(y) / uu / change,
                    model: p.hypot(q) / uu / change,
                    coherence: (x * x + y * y) / (uu * vv),
                }
            })
            .collect()
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value;
        count += 1.0;
    }
    sum / f64::max(count, 1.0)
}
