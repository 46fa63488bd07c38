//! The linear loop of a firmware: its velocity filter, its sums, its rate and delay, around q̈ = −a q̇ + b u.

use identifier_core::model::FrictionStep;
use identifier_core::number::Complex;
use identifier_core::tuning::{PossibleServo, PredictedSample, SampledServo, StepMeasure};

use super::firmware::{Estimator, Firmware};
use crate::result::{FormMargins, FormStep};

/// A loop as it runs, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FirmwareLoop {
    pub(super) firmware: &'static Firmware,
    pub(super) sample_time: f64,
    /// [α, β, γ], see [`Filter`](super::firmware::Filter).
    pub(super) filter: [f64; 3],
    pub(super) gains: [f64; 3],
}

impl FirmwareLoop {
    /// The command per position at ν = tan(ωT/2), command units per rad.
    fn controller(&self, nu: f64) -> Complex {
        let j = Complex { re: 0.0, im: nu };
        // 1 − 1/z of Tustin's z, and 1/z.
        let delta = j.scaled(2.0) / (j + 1.0);
        let before = Complex::ONE - delta;
        let [alpha, beta, direct] = self.filter;
        let own = (delta * delta).scaled(1.0 - alpha) + delta.scaled(alpha) + before.scaled(beta);
        let innovation = delta * delta / own;
        let motion = innovation.scaled(beta) / delta;
        let position = Complex::ONE - innovation.scaled(1.0 - alpha) + motion.scaled(direct);
        let rate = motion + innovation.scaled(direct * alpha);
        let velocity = rate.scaled(1.0 / self.sample_time);
        let newest = before.scaled(self.firmware.older) + (1.0 - self.firmware.older);
        let integral = newest.scaled(self.sample_time) / delta;
        let [first, second, third] = self.gains;
        let summed = integral.scaled(third) + second;
        match self.firmware.law {
            Estimator::Cascade => summed * (position.scaled(first) + velocity),
            _ => summed * position + velocity.scaled(first),
        }
    }

    /// Margins at the worst of servos, each with all of its delay. An unstable loop has an infinite sensitivity.
    pub(super) fn margins(&self, servos: &[PossibleServo], bandwidth: f64) -> FormMargins {
        /// The first frequency as a part of the bandwidth, the ratio of successive ones, and ν of the last.
        const FIRST: f64 = 0.01;
        const RATIO: f64 = 1.005;
        const LAST: f64 = 100.0;
        let (mut sensitivity, mut fall, mut rise) = (1.0_f64, 0.0_f64, 50.0_f64);
        for servo in servos {
            let sampled = SampledServo::new(servo, None, self.sample_time);
            let first = Some(0.5 * self.sample_time * FIRST * bandwidth);
            let frequencies = std::iter::successors(first, |nu| Some(RATIO * nu));
            // Nyquist's turns about −1 that are still to come, of a walk that begins on the real axis.
            let (mut awaited, mut last) = (0, Complex::new(-f64::MAX, -0.0));
            for nu in frequencies.take_while(|nu| *nu < LAST) {
                let (from, gain) = (last, sampled.at(nu) * self.controller(nu));
                sensitivity = sensitivity.max(1.0 / (gain + 1.0).power().sqrt());
                last = gain;
                if (from.im > 0.0) != (gain.im > 0.0) {
                    let at = from.re + (gain.re - from.re) * from.im / (from.im - gain.im);
                    if at < -1.0 {
                        awaited += if from.im > 0.0 { -1 } else { 1 };
                        fall = fall.max(-1.0 / at);
                    } else if at < 0.0 {
                        rise = rise.min(-1.0 / at);
                    }
                }
            }
            if awaited != 0 {
                sensitivity = f64::INFINITY;
            }
        }
        let gain_margins = [fall, rise];
        FormMargins {
            sensitivity,
            gain_margins,
        }
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
        let [first, second, third] = self.gains;
        let friction = FrictionStep::new();
        let mut measure = StepMeasure::<f64>::new(step, 0.0);
        let (mut target, mut sum, mut filter) = (0.0, 0.0, [0.0; 2]);
        let (mut position, mut velocity) = (0.0, 0.0);
        let mut commands = vec![0.0; delay as usize + 1];
        let sample = |sample: usize| {
            let [estimate, speed] = self.estimate(&mut filter, position);
            let moved = share * (step - target);
            target += moved;
            let (summed, rate) = match self.firmware.law {
                Estimator::Cascade => (first * (target - estimate) - speed, 0.0),
                Estimator::PidOnError => (target - estimate, moved / time - speed),
                _ => (target - estimate, -speed),
            };
            sum += time * summed;
            let integral = sum - self.firmware.older * time * summed;
            let command = second * summed + third * integral + first * rate;
            measure.take(position);
            let at = sample as f64 * time;
            let shown = PredictedSample {
                time: at,
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

    /// Position and velocity, of a filter's p and w and a measured position.
    fn estimate(&self, [p, w]: &mut [f64; 2], measured: f64) -> [f64; 2] {
        let [alpha, beta, direct] = self.filter;
        let innovation = measured - (*p + *w);
        *p += *w + alpha * innovation;
        *w += beta * innovation;
        let motion = *w + direct * alpha * innovation;
        [*p + direct * *w, motion / self.sample_time]
    }
}
