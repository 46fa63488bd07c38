//! The loop of a firmware as it runs, linear: its velocity estimate, its sums, its rate and delay, around
//! q̈ = −a q̇ + b u.

use identifier_core::number::Complex;
use identifier_core::tuning::{PossibleServo, SampledServo};

use crate::result::{FormMargins, FormStep};

/// An α-β filter of the position: prediction p + w, innovation e, p = prediction + α e, w += β e, with w the motion of a
/// sample. α = 1 is a first-order low-pass filter of the difference with the gain β; a phase-locked loop is one too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AlphaBeta {
    pub(super) alpha: f64,
    pub(super) beta: f64,
    /// Share of α e in the velocity.
    pub(super) direct: f64,
    pub(super) position: Position,
}

/// The position that the controller takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Position {
    /// As it is measured.
    Measured,
    /// p.
    Filtered,
    /// p + w, the next prediction.
    Predicted,
}

/// The structure of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    /// kp e + ki ∫e − kd v, with the gains [kp, ki, kd].
    Pid,
    /// The same with the derivative of the error.
    PidOnError,
    /// (Kv + Kvi ∫)(Kx e − v), with the gains [Kx, Kv, Kvi].
    Cascade,
    /// kp e alone.
    Proportional,
}

/// A loop as it runs, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FirmwareLoop {
    pub(super) sample_time: f64,
    pub(super) filter: AlphaBeta,
    /// Share of the newest error in the integral: 1, 0 where it is added after the output, ½ for trapezoids.
    pub(super) newest: f64,
    pub(super) law: Law,
    pub(super) gains: [f64; 3],
}

impl FirmwareLoop {
    /// The command per position at ν = tan(ωT/2), command units per rad.
    fn controller(&self, nu: f64) -> Complex {
        let j = Complex { re: 0.0, im: nu };
        // 1 − 1/z of Tustin's z.
        let difference = j.scaled(2.0) / (j + 1.0);
        let before = Complex::ONE - difference;
        let AlphaBeta {
            alpha,
            beta,
            direct,
            position,
        } = self.filter;
        let square = difference * difference;
        let innovation =
            square / (square.scaled(1.0 - alpha) + difference.scaled(alpha) + before.scaled(beta));
        let motion = innovation.scaled(beta) / difference;
        let filtered = Complex::ONE - innovation.scaled(1.0 - alpha);
        let velocity = (motion + innovation.scaled(direct * alpha)).scaled(1.0 / self.sample_time);
        let position = match position {
            Position::Measured => Complex::ONE,
            Position::Filtered => filtered,
            Position::Predicted => filtered + motion,
        };
        let integral =
            (before.scaled(1.0 - self.newest) + self.newest).scaled(self.sample_time) / difference;
        let [first, second, third] = self.gains;
        match self.law {
            Law::Cascade => (integral.scaled(third) + second) * (position.scaled(first) + velocity),
            _ => (integral.scaled(second) + first) * position + velocity.scaled(third),
        }
    }

    /// The largest sensitivity and the gain margins around servos, each with all of its delay, at the worst of them.
    /// An unstable loop has an infinite sensitivity.
    pub(super) fn margins(&self, servos: &[PossibleServo], bandwidth: f64) -> FormMargins {
        let mut margins = FormMargins {
            sensitivity: 1.0,
            gain_margins: [0.0, FormMargins::LARGEST],
        };
        for servo in servos {
            let mut before: Option<Complex> = None;
            // Nyquist: the turns about −1 that are still to come.
            let mut awaited = 0;
            for ([_, sensitivity], gain) in self.walk(servo, bandwidth) {
                margins.sensitivity = margins.sensitivity.max(sensitivity);
                let Some(last) = before.replace(gain) else {
                    awaited = i32::from(gain.im > 0.0);
                    continue;
                };
                if (last.im > 0.0) == (gain.im > 0.0) {
                    continue;
                }
                let at = last.re + (gain.re - last.re) * last.im / (last.im - gain.im);
                let [fall, rise] = &mut margins.gain_margins;
                if at < -1.0 {
                    awaited += if last.im > 0.0 { -1 } else { 1 };
                    *fall = fall.max(-1.0 / at);
                } else if at < 0.0 {
                    *rise = rise.min(-1.0 / at);
                }
            }
            if awaited != 0 {
                margins.sensitivity = f64::INFINITY;
            }
        }
        margins
    }

    /// Frequencies, rad/s, each with |S|, around a servo.
    pub(super) fn sensitivity(&self, servo: &PossibleServo, bandwidth: f64) -> Vec<[f64; 2]> {
        self.walk(servo, bandwidth)
            .map(|(point, _)| point)
            .collect()
    }

    /// Frequency, |S| and L from far below a bandwidth, rad/s, to half of the sampling frequency.
    fn walk(
        &self,
        servo: &PossibleServo,
        bandwidth: f64,
    ) -> impl Iterator<Item = ([f64; 2], Complex)> + use<'_> {
        /// The first frequency as a part of the bandwidth, and the ratio of successive ones.
        const FIRST: f64 = 0.01;
        const RATIO: f64 = 1.005;
        /// ν of the last, where z is −1 but for 2 %.
        const LAST: f64 = 100.0;
        let half = 0.5 * self.sample_time;
        let sampled = SampledServo::new(servo, None, self.sample_time);
        let first = Some(FIRST * bandwidth * half);
        std::iter::successors(first, |nu| Some(RATIO * nu))
            .take_while(|nu| *nu < LAST)
            .map(move |nu| {
                let gain = sampled.at(nu) * self.controller(nu);
                let sensitivity = 1.0 / (gain + 1.0).power().sqrt();
                ([nu.atan() / half, sensitivity], gain)
            })
    }

    /// The step of the reference of one rad, smoothed by a first-order filter (s, 0 for none): its samples of time,
    /// position and command.
    pub(super) fn step(&self, servo: &PossibleServo, smoothing: f64, until: f64) -> Vec<[f64; 3]> {
        /// Samples that are computed at most.
        const MOST: f64 = 1e6;
        let time = self.sample_time;
        let delay = servo.delay / time;
        let (whole, part) = (delay.floor() as usize, delay.fract());
        let share = if smoothing > 0.0 {
            -(-time / smoothing).exp_m1()
        } else {
            1.0
        };
        let parts = [part, 1.0 - part].map(|part| Hold::new(servo, part * time));
        // The filters of the position and of the error, the integral, and the servo.
        let (mut measured, mut derived) = ([0.0; 2], [0.0; 2]);
        let (mut reference, mut sum, mut motion) = (0.0, 0.0, [0.0; 2]);
        let mut commands = vec![0.0; whole + 1];
        let count = (until / time).min(MOST) as usize;
        let mut samples = Vec::with_capacity(count);
        for sample in 0..count {
            reference += share * (1.0 - reference);
            let [position, velocity] = self.estimate(&mut measured, motion[0]);
            let error = reference - position;
            let [first, second, third] = self.gains;
            let mut integral = |error: f64| {
                let before = sum;
                sum += time * error;
                before + self.newest * (sum - before)
            };
            let command = match self.law {
                Law::Cascade => {
                    let error = first * error - velocity;
                    second * error + third * integral(error)
                }
                Law::PidOnError => {
                    let [_, rate] = self.estimate(&mut derived, reference - motion[0]);
                    first * error + second * integral(error) + third * rate
                }
                Law::Pid | Law::Proportional => {
                    first * error + second * integral(error) - third * velocity
                }
            };
            samples.push([sample as f64 * time, motion[0], command]);
            commands.push(command);
            let acting = [sample, sample + 1].map(|at| commands.get(at).copied().unwrap_or(0.0));
            for (hold, command) in parts.iter().zip(acting) {
                motion = hold.of(motion, command);
            }
        }
        samples
    }

    /// Position and velocity, of a filter's p and w and a measured position.
    fn estimate(&self, [p, w]: &mut [f64; 2], measured: f64) -> [f64; 2] {
        let innovation = measured - (*p + *w);
        *p += *w + self.filter.alpha * innovation;
        *w += self.filter.beta * innovation;
        let motion = *w + self.filter.direct * self.filter.alpha * innovation;
        let position = match self.filter.position {
            Position::Measured => measured,
            Position::Filtered => *p,
            Position::Predicted => *p + *w,
        };
        [position, motion / self.sample_time]
    }
}

/// The motion of a servo under a command that is held.
struct Hold {
    time: f64,
    /// b.
    gain: f64,
    /// What remains of a velocity, and the first and second integral of that.
    remains: [f64; 3],
}

impl Hold {
    fn new(servo: &PossibleServo, time: f64) -> Self {
        let x = servo.a * time;
        let (once, twice) = if x > 1e-4 {
            let once = -(-x).exp_m1() / x;
            (once, (1.0 - once) / x)
        } else {
            (1.0 - 0.5 * x, 0.5 - x / 6.0)
        };
        Self {
            time,
            gain: servo.b,
            remains: [(-x).exp(), time * once, time * time * twice],
        }
    }

    fn of(&self, [position, velocity]: [f64; 2], command: f64) -> [f64; 2] {
        if self.time == 0.0 {
            return [position, velocity];
        }
        let push = self.gain * command;
        let [remains, once, twice] = self.remains;
        [
            position + once * velocity + twice * push,
            remains * velocity + once * push,
        ]
    }
}

impl FormStep {
    /// Of the samples of a step of one rad.
    pub(super) fn of(samples: &[[f64; 3]], smoothing: f64) -> Self {
        let reaches = |level: f64| {
            let next = samples.windows(2).find(|pair| pair[1][1] >= level)?;
            let [[from, low, _], [to, high, _]] = [next[0], next[1]];
            Some(from + (to - from) * (level - low) / (high - low))
        };
        let rise_time = reaches(0.9)
            .zip(reaches(0.1))
            .map(|(end, begin)| end - begin);
        let highest = samples.iter().map(|sample| sample[1]).fold(1.0, f64::max);
        Self {
            smoothing,
            rise_time,
            overshoot: highest - 1.0,
        }
    }
}
