//! A log beside the model that was identified from it, as one sees whether the model is right.

use std::f64::consts::TAU;

use identifier_core::parameters::Unknown;
use log_fit::Logged;

use super::whole_record::WholeRecord;
use crate::scaled_recording::ScaledRecording;
use crate::scenario::Options;
use crate::verdict::Residual;

/// The residuals of a model over its log, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// The model by the command alone; none if no part of the log is long enough to tell where it starts.
    pub free_run: Option<FreeRun>,
    /// A count, rad; none of a log of velocities, which has no encoder.
    pub count: Option<f64>,
    /// Deviation of the model's prediction of the next sample, rad.
    pub innovation: f64,
    /// Correlation of that from sample to sample.
    pub correlation: f64,
    /// The friction by velocity.
    pub friction: Vec<Braking>,
    /// The response by frequency, from the command to the velocity, where the motion shows it and the model ran free.
    pub response: Vec<FoundResponse>,
    /// True if the reference is known, which is then the instrument of the response.
    pub has_reference: bool,
}

impl Seen {
    /// What the fit of a record leaves from one sample to the next, beside the noise of the sensor.
    pub(crate) fn innovation(&self, whole: &WholeRecord) -> Residual {
        Residual {
            rms: self.innovation,
            resolution_rms: whole.found.statistics.noise * whole.scale.position,
            correlation: self.correlation,
        }
    }

    /// The residuals over the samples that a fit explains; none if the model diverges in them.
    #[must_use]
    pub fn new(
        scenario: &Options,
        samples: &[Logged],
        references: &[f64],
        whole: &WholeRecord,
    ) -> Option<Self> {
        let ScaledRecording { recording, scale } = ScaledRecording::new(scenario, samples);
        let count = scale.position;
        let course = whole.found.course(&recording)?;
        let free_run = course.free_run.map(|ran| {
            let errors: Vec<f64> = ran.errors.iter().map(|error| count * error).collect();
            let known = errors.iter().filter(|error| error.is_finite());
            FreeRun {
                window: ran.window as f64 * scenario.sample_time(),
                deviation: mean(known.map(|error| error * error)).sqrt(),
                errors,
            }
        });
        let innovation = count * course.innovation;
        let motion = Motion {
            samples,
            sample_time: scenario.sample_time(),
        };
        let log = scenario.log.as_ref();
        let is_velocity = log.is_some_and(|log| log.is_velocity);
        let noise = Noise {
            deviation: innovation,
            differences: if is_velocity { 1 } else { 2 },
        };
        let has_reference = is_known(references);
        let instrument = if has_reference { references } else { &[] };
        Some(Self {
            count: (!is_velocity).then_some(count),
            has_reference,
            innovation,
            correlation: course.correlation,
            friction: motion.friction(whole, innovation),
            response: (free_run.as_ref()).map_or_else(Vec::new, |ran| {
                motion.response(&ran.errors, instrument, noise)
            }),
            free_run,
        })
    }
}

/// A model that runs free in windows, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeRun {
    /// The measured position minus that of the model for every sample, rad. NaN until the start of its window is known.
    pub errors: Vec<f64>,
    /// Length of a window, s.
    pub window: f64,
    /// Deviation of the errors, rad.
    pub deviation: f64,
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
    /// The part of the log's velocity that is coherent with the reference, or else with the command, 0 to 1.
    pub coherence: f64,
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
        let of_all = |pick: fn(f64, f64) -> f64| points.iter().map(|point| point[0]).reduce(pick);
        let (Some(low), Some(high)) = (of_all(f64::min), of_all(f64::max)) else {
            return Vec::new();
        };
        let width = (high - low) / BINS as f64;
        // Of one that holds zero there are two.
        let mut bins = vec![Vec::new(); 2 * (BINS + 1)];
        for point in points {
            let bin = ((point[0] - low) / width) as usize;
            bins[2 * bin.min(BINS) + usize::from(point[0] > 0.0)].push(point);
        }
        bins.into_iter()
            .filter(|bin| bin.len() >= FEWEST)
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
    ///
    /// In closed loop the command contains the controller's answer to the sensor's noise: what it has in common with the
    /// velocity is then the controller's inverse. A reference has no part in that noise, so both are related to it
    /// (instrumental variable: Söderström and Stoica, System Identification, 1989, 10.3). Without one, only the lines are
    /// kept at which the motion is far above the noise.
    fn response(self, errors: &[f64], references: &[f64], noise: Noise) -> Vec<FoundResponse> {
        const FREQUENCIES: usize = 30;
        const WINDOWS: usize = 16;
        /// Steps of a window, which are rows, or several together where a twelfth of the log has more.
        const LENGTH: [usize; 2] = [64, 2048];
        /// The least coherence with a reference, of 16 windows: a gain is then known to a tenth.
        const COHERENT: f64 = 0.8;
        /// The least power of the motion over that of the noise: ten times as large.
        const ABOVE_NOISE: f64 = 100.0;
        let each = (self.samples.len() / 12).div_ceil(LENGTH[1]).max(1);
        let time = each as f64 * self.sample_time;
        // Where a window begins the model is where the servo is.
        let left = |at: usize| Some(errors[at]).filter(|error| error.is_finite());
        let has_reference = !references.is_empty();
        let steps: Vec<Option<[f64; 4]>> = (1..self.samples.len() / each)
            .map(|step| {
                let (from, to) = ((step - 1) * each, step * each);
                let rows = &self.samples[from..=to];
                let moved = rows[each].position - rows[0].position;
                let model = moved - left(to).unwrap_or(0.0) + left(from).unwrap_or(0.0);
                let command = mean(rows[..each].iter().map(|row| row.command));
                let instrument = match has_reference {
                    true => (references[to] - references[from]) / time,
                    false => command,
                };
                let is_one = rows[1..].iter().all(|row| !row.begins);
                is_one.then_some([instrument, command, moved / time, model / time])
            })
            .collect();
        let length = (steps.len() / 12).clamp(LENGTH[0], LENGTH[1]);
        let apart = (length / 2).max(steps.len().saturating_sub(length) / WINDOWS);
        let windows: Vec<Vec<[f64; 4]>> = (0..)
            .map(|k| k * apart)
            .take_while(|first| first + length <= steps.len())
            .filter_map(|first| steps[first..first + length].iter().copied().collect())
            .collect();
        if windows.len() < 4 {
            return Vec::new();
        }
        let lowest = 3.0 * TAU / length as f64;
        let ratio = (0.8 * std::f64::consts::PI / lowest).powf(1.0 / (FREQUENCIES - 1) as f64);
        let at = |k: usize| {
            let frequency = lowest * ratio.powi(k as i32);
            let change = 2.0 * (0.5 * frequency).sin();
            // Powers of command, velocity and model, of the instrument, and what they have in common with it.
            let mut powers = [0.0_f64; 4];
            let mut common = [[0.0_f64; 2]; 4];
            let mut weights = 0.0;
            for window in &windows {
                let mut spectra = [[0.0_f64; 2]; 4];
                for (place, pair) in window.windows(2).enumerate() {
                    // Velocities are far larger at low frequencies, and would leak from there: their changes are not.
                    let [[r, _, v, m], [next_r, command, next_v, next_m]] = [pair[0], pair[1]];
                    let instrument = if has_reference { next_r - r } else { next_r };
                    let values = [instrument, command, next_v - v, next_m - m];
                    let weight = 1.0 - (TAU * place as f64 / length as f64).cos();
                    let (sine, cosine) = (frequency * place as f64).sin_cos();
                    weights += weight * weight;
                    for (spectrum, value) in spectra.iter_mut().zip(values) {
                        spectrum[0] += weight * value * cosine;
                        spectrum[1] -= weight * value * sine;
                    }
                }
                let by = spectra[0];
                for ((power, common), a) in powers.iter_mut().zip(&mut common).zip(spectra) {
                    *power += a[0] * a[0] + a[1] * a[1];
                    common[0] += a[0] * by[0] + a[1] * by[1];
                    common[1] += a[1] * by[0] - a[0] * by[1];
                }
            }
            let [_, command, measured, model] = common.map(|common| common[0].hypot(common[1]));
            let [own, of_command, of_motion, _] = powers;
            let coherent = |common: f64, power: f64| common * common / (own * power);
            let coherence = coherent(measured, of_motion);
            let noise = (noise.deviation / time).powi(2) * change.powi(2 * noise.differences);
            let is_shown = match has_reference {
                true => coherence.min(coherent(command, of_command)) >= COHERENT,
                false => of_motion >= ABOVE_NOISE * weights * noise,
            };
            is_shown.then_some(FoundResponse {
                frequency: frequency / time,
                measured: measured / command / change,
                model: model / command / change,
                coherence,
            })
        };
        (0..FREQUENCIES).filter_map(at).collect()
    }
}

/// The sensor's noise in the steps of the velocity.
#[derive(Debug, Clone, Copy)]
struct Noise {
    /// Of a position, rad.
    deviation: f64,
    /// How often white noise is differenced there.
    differences: i32,
}

/// True for references that are known throughout and move.
fn is_known(references: &[f64]) -> bool {
    references.iter().all(|reference| reference.is_finite())
        && references.windows(2).any(|pair| pair[0] < pair[1])
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value;
        count += 1.0;
    }
    sum / f64::max(count, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use virtual_servo::excitation::NormalSource;

    const TIME: f64 = 1e-3;
    const LAG: f64 = 4e-3;
    const GAIN: f64 = 50.0;
    const DEVIATION: f64 = 0.5;

    /// The response of a double integrator behind a current loop, from held commands to the mean velocity from sample to
    /// sample: b (T/2) (z + 1)/(z − 1) · (1 − p)/(z − p).
    fn response(frequency: f64) -> f64 {
        let pole = (-TIME / LAG).exp();
        let half = 0.5 * frequency * TIME;
        let distance = (1.0 - 2.0 * pole * (2.0 * half).cos() + pole * pole).sqrt();
        0.5 * TIME * GAIN / half.tan() * (1.0 - pole) / distance
    }

    /// The response of that integrator under white commands, measured with white noise of a deviation, rad, beside a model
    /// that is exact.
    fn found(noise: f64) -> Vec<FoundResponse> {
        let mut white = NormalSource::new(1);
        let [mut position, mut velocity, mut acting] = [0.0; 3];
        let pole = (-TIME / LAG).exp();
        let (mut samples, mut errors) = (Vec::new(), Vec::new());
        for k in 0..24_000 {
            let command = DEVIATION * white.next_normal();
            let error = noise * white.next_normal();
            samples.push(Logged {
                position: position + error,
                command,
                begins: k == 0,
            });
            errors.push(error);
            position += TIME * velocity + 0.5 * TIME * TIME * GAIN * acting;
            velocity += TIME * GAIN * acting;
            acting = pole * acting + (1.0 - pole) * command;
        }
        let motion = Motion {
            samples: &samples,
            sample_time: TIME,
        };
        let noise = Noise {
            deviation: 0.0,
            differences: 2,
        };
        motion.response(&errors, &[], noise)
    }

    /// Windows of that record with little overlap.
    const WINDOWS: f64 = 17.0;

    /// Three standard errors of a gain at its coherence, part of it, and a hundredth for the window's width.
    fn allowed(coherence: f64) -> f64 {
        0.01 + 3.0 * ((1.0 - coherence) / (2.0 * WINDOWS * coherence)).sqrt()
    }

    #[test]
    fn the_response_of_an_integrator_with_a_lag_is_its_own() {
        let found = found(0.0);
        assert_eq!(found.len(), 30);
        for one in &found {
            let wanted = response(one.frequency);
            for gain in [one.measured, one.model] {
                let off = (gain / wanted - 1.0).abs();
                assert!(off < allowed(one.coherence), "{one:?}: {wanted}");
            }
        }
        let coherence = mean(found.iter().map(|one| one.coherence));
        assert!(coherence > 0.98, "{coherence}");
    }

    #[test]
    fn coherence_falls_with_noise_as_it_must() {
        for noise in [1e-5, 1e-4] {
            let found = found(noise);
            let wanted = |one: &FoundResponse| {
                // Spectra of the motion, and of the difference of two measurements.
                let motion = (DEVIATION * response(one.frequency)).powi(2);
                let error = (2.0 * noise / TIME * (0.5 * one.frequency * TIME).sin()).powi(2);
                let coherence = motion / (motion + error);
                coherence + (1.0 - coherence).powi(2) / WINDOWS
            };
            let off = mean(found.iter().map(|one| one.coherence - wanted(one)));
            assert!(off.abs() < 0.05, "{off}");
            let lost = found.iter().filter(|one| wanted(one) < 0.5);
            let seen = mean(lost.clone().map(|one| one.coherence));
            assert!(lost.count() >= 5 && seen < 0.4, "{seen}");
            for one in found.iter().filter(|one| one.coherence > 0.5) {
                let off = (one.measured / response(one.frequency) - 1.0).abs();
                assert!(off < allowed(one.coherence), "{one:?}");
            }
        }
    }
}
