//! The loop of a firmware as it runs: its filter, its sums, its limits, its rate and delay, around q̈ = −a q̇ + b u.

use std::collections::VecDeque;

use identifier_core::model::FrictionStep;
use identifier_core::number::Complex;
use identifier_core::tuning::{PossibleServo, PredictedSample, SampledServo, StepMeasure};

use super::firmware::{AntiWindup, Estimator, Firmware};
use crate::result::{FormMargins, FormStep};

/// A loop as it runs, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FirmwareLoop {
    pub(super) firmware: &'static Firmware,
    pub(super) sample_time: f64,
    /// [α, β, γ], see [`Filter`](super::firmware::Filter).
    pub(super) filter: [f64; 3],
    pub(super) gains: [f64; 3],
    /// The largest command, command units.
    pub(super) limit: f64,
}

/// The controller of a loop, sample by sample.
#[derive(Debug, Clone)]
pub(super) struct Controller {
    of: FirmwareLoop,
    /// p and w of the filter.
    filter: [f64; 2],
    sum: f64,
    /// The targets that the error is still to have, the oldest first.
    targets: VecDeque<f64>,
    target: f64,
    /// −1, 0 or 1 where the last output was at its limit.
    at_limit: f64,
}

impl FirmwareLoop {
    /// The command per position at ν = tan(ωT/2), command units per rad.
    pub(super) fn controller(&self, nu: f64) -> Complex {
        let j = Complex { re: 0.0, im: nu };
        // 1 − 1/z of Tustin's z, and 1/z.
        let delta = j.scaled(2.0) / (j + 1.0);
        let before = Complex::ONE - delta;
        let [alpha, beta, ahead] = self.filter;
        let own = (delta * delta).scaled(1.0 - alpha) + delta.scaled(alpha) + before.scaled(beta);
        let innovation = delta * delta / own;
        let motion = innovation.scaled(beta) / delta;
        let position = Complex::ONE - innovation.scaled(1.0 - alpha) + motion.scaled(ahead);
        let velocity = motion.scaled(1.0 / self.sample_time);
        let newest = before.scaled(self.firmware.older) + (1.0 - self.firmware.older);
        let integral = newest.scaled(self.sample_time) / delta;
        let [first, second, third] = self.gains;
        let summed = integral.scaled(third) + second;
        match self.firmware.law {
            Estimator::Cascade => summed * (position.scaled(first) + velocity),
            _ => summed * position + velocity.scaled(first),
        }
    }

    /// Margins at the worst of servos, each with all of its delay and the largest sensitivity that is allowed with it, and
    /// whether all have that. An unstable loop has an infinite sensitivity. The prediction is that of servos with as many masses
    /// as were identified, without those that may differ from its resonance.
    pub(super) fn margins(
        &self,
        servos: impl Iterator<Item = (SampledServo, f64)>,
        [bandwidth, max_sensitivity]: [f64; 2],
        has_resonance: bool,
    ) -> (FormMargins, bool) {
        /// The first frequency as a part of the bandwidth, the ratio of successive ones, ν of the last, and the next one
        /// near a resonance as a part of the distance to it and of its width.
        const FIRST: f64 = 0.01;
        const RATIO: f64 = 1.005;
        const LAST: f64 = 100.0;
        const APPROACH: f64 = 0.1;
        /// Tolerance to which searches meet a sensitivity.
        const TOLERANCE: f64 = 1.005;
        let (mut worst, mut fall, mut rise) = (1.0_f64, 0.0_f64, 50.0_f64);
        let mut keeps = true;
        for (servo, allowed) in servos {
            let resonance = servo.resonance();
            let first = Some(0.5 * self.sample_time * FIRST * bandwidth);
            let frequencies = std::iter::successors(first, |nu| {
                let near = resonance.map_or(f64::INFINITY, |(at, width)| {
                    APPROACH * (nu - at).abs().max(width)
                });
                Some(nu + ((RATIO - 1.0) * nu).min(near))
            });
            let is_predicted = allowed <= max_sensitivity && resonance.is_some() == has_resonance;
            let mut sensitivity = 1.0_f64;
            // Nyquist's turns about −1 that are still to come, of a walk that begins on the real axis.
            let (mut awaited, mut last) = (0, Complex::new(-f64::MAX, -0.0));
            for nu in frequencies.take_while(|nu| *nu < LAST) {
                let (from, gain) = (last, servo.at(nu) * self.controller(nu));
                sensitivity = sensitivity.max(1.0 / (gain + 1.0).power().sqrt());
                last = gain;
                if (from.im > 0.0) != (gain.im > 0.0) {
                    let at = from.re + (gain.re - from.re) * from.im / (from.im - gain.im);
                    if at < -1.0 {
                        awaited += if from.im > 0.0 { -1 } else { 1 };
                    }
                    if at < -1.0 && is_predicted {
                        fall = fall.max(-1.0 / at);
                    } else if at < 0.0 && is_predicted {
                        rise = rise.min(-1.0 / at);
                    }
                }
            }
            if awaited != 0 {
                sensitivity = f64::INFINITY;
            }
            keeps &= sensitivity <= TOLERANCE * allowed;
            if is_predicted {
                worst = worst.max(sensitivity);
            }
        }
        let margins = FormMargins {
            sensitivity: worst,
            gain_margins: [fall, rise],
        };
        (margins, keeps)
    }

    /// A step of the target, rad, through a first-order filter (s, 0 for none) in the sending program, until a time, s.
    pub(super) fn step(
        &self,
        servo: &PossibleServo,
        [step, smoothing, until]: [f64; 3],
    ) -> (FormStep, Vec<PredictedSample>) {
        /// Samples that are computed at most.
        const MOST: f64 = 1e6;
        let time = self.sample_time;
        let delay = servo.delay / time;
        let parts = [delay.fract(), 1.0 - delay.fract()].map(|part| part * time);
        let share = -(-time / smoothing).exp_m1();
        let friction = FrictionStep::new();
        let mut measure = StepMeasure::<f64>::new(step, 0.0);
        let mut controller = Controller::new(*self);
        let (mut target, mut position, mut velocity) = (0.0, 0.0, 0.0);
        let mut commands = vec![0.0; delay as usize + 1];
        let sample = |sample: usize| {
            target += share * (step - target);
            let command = controller.process(target, position);
            measure.take(position);
            let shown = PredictedSample {
                time: sample as f64 * time,
                position,
                command,
            };
            commands.push(command);
            for (part, command) in parts.iter().zip(commands.iter().skip(sample)) {
                if *part > 0.0 {
                    let drive = servo.b * command * part * part;
                    let (motion, _) = friction.process(servo.a * part, drive, 0.0, velocity * part);
                    position += motion.increment;
                    velocity = motion.velocity / part;
                }
            }
            shown
        };
        let samples = (0..(until / time).min(MOST) as usize).map(sample).collect();
        let step = FormStep {
            smoothing,
            rise_time: measure.rise().map(|rise| rise * time),
            overshoot: measure.overshoot(),
        };
        (step, samples)
    }
}

impl Controller {
    /// At rest at a position and a target of zero.
    pub(super) fn new(of: FirmwareLoop) -> Self {
        Self {
            of,
            filter: [0.0; 2],
            sum: 0.0,
            targets: std::iter::repeat_n(0.0, of.firmware.target_delay).collect(),
            target: 0.0,
            at_limit: 0.0,
        }
    }

    /// The command of a sample, command units, for a target and a measured position, rad.
    pub(super) fn process(&mut self, target: f64, measured: f64) -> f64 {
        let FirmwareLoop {
            firmware,
            sample_time: time,
            gains: [first, second, third],
            limit,
            ..
        } = self.of;
        let [position, velocity] = self.estimate(measured);
        let target_rate = (target - self.target) / time;
        self.target = target;
        self.targets.push_back(target);
        let target = self.targets.pop_front().unwrap_or(target);
        let most = firmware.velocity_limit.unwrap_or(f64::INFINITY);
        let (summed, rate) = match firmware.law {
            Estimator::Cascade => {
                let wanted = first * (target - position);
                (wanted.clamp(-most, most) - velocity, 0.0)
            }
            Estimator::PidOnError => (target - position, target_rate - velocity),
            _ => (target - position, -velocity),
        };
        let proportional = second * summed;
        let before = self.sum;
        self.sum += match firmware.anti_windup {
            AntiWindup::Decay if self.at_limit != 0.0 => -0.01 * self.sum,
            AntiWindup::Conditional if summed * self.at_limit > 0.0 => 0.0,
            _ => time * summed,
        };
        let room = match firmware.anti_windup {
            AntiWindup::Clamped => limit,
            AntiWindup::Headroom => (limit - proportional.abs()).max(0.0),
            _ => f64::INFINITY,
        };
        if third > 0.0 {
            self.sum = self.sum.clamp(-room / third, room / third);
        }
        let integral = third * (self.sum + firmware.older * (before - self.sum));
        let derivative = match firmware.law {
            Estimator::Cascade => 0.0,
            _ => first * rate,
        };
        let command = proportional + integral + derivative;
        let limited = command.clamp(-limit, limit);
        self.at_limit = if command.abs() > limit {
            command.signum()
        } else {
            0.0
        };
        limited
    }

    /// Position and velocity, of a measured position.
    fn estimate(&mut self, measured: f64) -> [f64; 2] {
        let [alpha, beta, ahead] = self.of.filter;
        let [p, w] = &mut self.filter;
        let innovation = measured - (*p + *w);
        *p += *w + alpha * innovation;
        *w += beta * innovation;
        [*p + ahead * *w, *w / self.of.sample_time]
    }
}
