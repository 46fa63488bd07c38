//! The motion of a run, before anything is identified from it.

use crate::verdict::MIN_TRAVEL_COUNTS;
use identifier_core::parameters::{Parameter, Unknown};

use super::information::Information;
use crate::analysis::NoiseMeter;
use crate::experiment::{Outcome, Sample};
use crate::result::{Known, SensorNoise};
use crate::scenario::{Fault, Scenario};
use crate::simulate;

/// Properties of a run's motion.
#[derive(Debug)]
pub(super) struct Rehearsal {
    /// Deviation of the position, rad, and of the command.
    pub(super) position: f64,
    pub(super) command: f64,
    /// The part of the samples in which the command is at its limit.
    pub(super) limited: f64,
    /// Accuracy of each unknown, with its time.
    pub(super) known: Vec<Known>,
    /// Noise of the position sensor.
    pub(super) noise: SensorNoise,
    /// The record of the run.
    pub(super) outcome: Outcome,
}

/// Sums over the samples.
struct Motion {
    information: Information,
    noise: NoiseMeter,
    /// Weight of a new step in the velocity.
    new: f64,
    sample_time: f64,
    limit: [f64; 2],
    last: Option<f64>,
    /// The distance travelled, forth and back, and the least that is informative, rad.
    travel: f64,
    least_travel: f64,
    velocity: f64,
    samples: f64,
    position: [f64; 2],
    command: [f64; 2],
    speed: f64,
    limited: f64,
    /// Time at which each was first known, s.
    since: Vec<Option<f64>>,
}

impl Rehearsal {
    /// Moves the servo of a scenario, and looks at the motion with a correction of this bandwidth, rad/s.
    pub(super) fn run(scenario: &Scenario, omega: f64) -> Result<Self, Fault> {
        let parameters = scenario.estimated();
        let servo = scenario
            .plant
            .ok_or_else(|| Fault::new("plant", "a rehearsal needs a servo"))?;
        let resolution = scenario.stated.resolution;
        let noise = scenario.sensor.noise;
        let variance = resolution * resolution / 12.0 + noise * noise;
        let sample_time = scenario.sample_time();
        let mut motion = Motion {
            information: Information::new(&parameters, &servo, omega, sample_time, variance),
            noise: NoiseMeter::new(resolution),
            new: -(-scenario.stated.cutoff * sample_time).exp_m1(),
            sample_time,
            limit: scenario.controller().limit,
            last: None,
            travel: 0.0,
            least_travel: MIN_TRAVEL_COUNTS * resolution,
            velocity: 0.0,
            samples: 0.0,
            position: [0.0; 2],
            command: [0.0; 2],
            speed: 0.0,
            limited: 0.0,
            since: vec![None; parameters.len()],
        };
        let outcome = simulate::run(scenario, &mut |sample| motion.add(sample, &parameters))?;
        let errors = motion.standard_errors();
        let ran_through = outcome.abort.is_none();
        let known = parameters.iter().enumerate().map(|(place, parameter)| {
            let tolerance = motion.tolerance(*parameter);
            let error = errors[place];
            let end = motion.samples * sample_time;
            Known {
                unknown: Unknown::from(*parameter).name(),
                unit: Unknown::from(*parameter).unit(),
                std_error: error.is_finite().then_some(error),
                needed: tolerance,
                // Standard errors fall with the square root of time, of a run that can be longer.
                from: motion.since[place]
                    .filter(|_| is_enough(error, tolerance))
                    .or_else(|| {
                        let times = (error / tolerance).powi(2);
                        let can_be_longer = ran_through && end > 0.0;
                        (times.is_finite() && can_be_longer).then_some(end * times)
                    }),
                within_run: is_enough(error, tolerance),
            }
        });
        let known = known.collect();
        let deviation = |[mean, square]: [f64; 2]| {
            let count = motion.samples.max(1.0);
            (square / count - (mean / count).powi(2)).max(0.0).sqrt()
        };
        Ok(Self {
            position: deviation(motion.position),
            command: deviation(motion.command),
            limited: motion.limited / motion.samples.max(1.0),
            known,
            noise: motion.noise.noise(),
            outcome,
        })
    }
}

/// True if a parameter with this standard error is known to a tolerance; what did not move has none.
fn is_enough(error: f64, tolerance: f64) -> bool {
    error.is_finite() && error <= tolerance
}

impl Motion {
    fn add(&mut self, sample: &Sample, parameters: &[Parameter]) {
        /// Times at which it is looked whether something is known, in a row.
        const RATIO: f64 = 1.05;
        let moved = self.last.map_or(0.0, |last| sample.position - last);
        self.last = Some(sample.position);
        self.noise.add(sample.position, sample.begins);
        self.travel += moved.abs();
        self.velocity += self.new * (moved / self.sample_time - self.velocity);
        self.information.add(self.velocity, sample.command);
        let before = (self.samples + 1.0).ln() / RATIO.ln();
        self.samples += 1.0;
        let now = (self.samples + 1.0).ln() / RATIO.ln();
        let add = |sums: &mut [f64; 2], value: f64| {
            sums[0] += value;
            sums[1] += value * value;
        };
        add(&mut self.position, sample.position);
        add(&mut self.command, sample.command);
        self.speed += self.velocity * self.velocity;
        let [low, high] = self.limit;
        self.limited += f64::from(u8::from(sample.command <= low || sample.command >= high));
        if before.floor() < now.floor() {
            let errors = self.standard_errors();
            for (place, error) in errors.into_iter().enumerate() {
                let is_known = is_enough(error, self.tolerance(parameters[place]));
                let since = &mut self.since[place];
                *since = since.or(Some(sample.time)).filter(|_| is_known);
            }
        }
    }

    /// The least standard errors, SI; infinite where the motion says nothing.
    fn standard_errors(&self) -> Vec<f64> {
        let errors = self.information.standard_errors();
        if self.travel < self.least_travel {
            return vec![f64::INFINITY; errors.len()];
        }
        errors
    }

    /// The standard error from which on a parameter counts as known, SI: as in the verdict.
    fn tolerance(&self, parameter: Parameter) -> f64 {
        let servo = self.information.servo();
        let root_mean = |sum: f64| (sum / self.samples.max(1.0)).sqrt();
        let acceleration = servo.b * root_mean(self.command[1]);
        let rate = acceleration / root_mean(self.speed).max(f64::MIN_POSITIVE);
        match parameter {
            Parameter::B => 0.015 * servo.b,
            Parameter::A => (0.05 * servo.a).max(0.01 * rate),
            Parameter::Coulomb => (0.05 * servo.coulomb).max(0.005 * acceleration),
            Parameter::Load => (0.05 * servo.load.abs()).max(0.005 * acceleration),
        }
    }
}
