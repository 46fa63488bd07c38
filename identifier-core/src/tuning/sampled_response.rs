//! The frequency response of the sampled loop, exact: held command, fractional delay, velocity estimate and
//! sum as they run.
//!
//! Let δ = z − 1, x = a T, and h₁, h₂ as in [`ZeroOrderHoldStep`]. The servo per command, in rad, is
//!
//! b T² z^−(m+1) ((δ + x h₁)(q₁ z + q₀) + h₁ (v₁ z + v₀)) / (δ (δ + x h₁)),
//!
//! where the delay is m whole samples and a part φ of one. Over the last 1 − φ of a sample a command adds q₁ to the
//! position and v₁ to the velocity. The command before it adds q₀ = h₂ − q₁ and v₀ = h₁ − v₁. The controller is k_p +
//! (k_d/T) g δ/(δ + g) + k_i T/δ, g = 1 − e^(−cutoff T).
//!
//! For two masses the mode is added to the servo ([`SampledMode`]).
//!
//! Frequencies follow Tustin's z = (1 + jν)/(1 − jν), ν = tan(ωT/2). So no point needs a transcendental function. δ =
//! 2jν/(1 − jν) keeps all its digits where z is near one.

use super::placement::Design;
use super::possible_servos::PossibleServo;
use super::resonance::{Mode, Resonance};
use super::sampled_mode::SampledMode;
use crate::control::notch_at;
use crate::model::ZeroOrderHoldStep;
use crate::number::{Complex, Number};

/// A servo's sampled response to its command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledServo<N = f64> {
    whole_delay: u32,
    /// x h₁.
    decay: N,
    h1: N,
    /// Position and velocity that a command adds in its first sample.
    newer: [N; 2],
    /// Position and velocity that it adds in the sample after that.
    older: [N; 2],
    /// b T².
    gain: N,
    mode: Option<SampledMode<N>>,
    /// What the motor's friction adds where both masses slow down, newer and older.
    slowed: [N; 2],
}

/// The sampled response of the controller of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SampledController {
    filter: f64,
    /// k_p, k_d/T g and k_i T, times a factor.
    gains: [f64; 3],
    /// ν of the notch, if there is one.
    notch: Option<f64>,
}

/// The loop of a design around a servo, opened at the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SampledResponse {
    servo: SampledServo,
    /// Times b T².
    controller: SampledController,
}

/// The loop at a frequency: L = forward/open, and the characteristic function open + forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// δ² (δ + x h₁)(δ + g).
    pub(super) open: Complex,
    pub(super) forward: Complex,
}

/// ν at a frequency, rad/s; none from half of the sampling frequency on.
pub(super) fn nu_at(frequency: f64, sample_time: f64) -> Option<f64> {
    let angle = frequency * sample_time;
    (angle > 0.0 && angle < core::f64::consts::PI).then(|| {
        let (sine, cosine) = libm::sincos(0.5 * angle);
        sine / cosine
    })
}

/// δ = z − 1 at ν = tan(ωT/2).
fn delta_at(nu: f64) -> Complex {
    let sine = 2.0 * nu / (1.0 + nu * nu);
    Complex {
        re: -nu * sine,
        im: sine,
    }
}

impl SampledServo {
    /// The response of one mass, or of two with their mode. The sample time is in s; a T is at most half, the delay at
    /// most 1000 samples.
    #[must_use]
    pub fn new(servo: &PossibleServo, mode: Option<&Mode>, sample_time: f64) -> Self {
        let step = ZeroOrderHoldStep::<f64>::new();
        let x = servo.a * sample_time;
        let (whole_delay, part) = split(servo.delay / sample_time);
        let held = step.response(x);
        let newest = step.partial_response(x, 1.0 - part);
        Self {
            whole_delay,
            decay: x * held.velocity,
            h1: held.velocity,
            newer: [newest.displacement, newest.velocity],
            older: [
                held.displacement - newest.displacement,
                held.velocity - newest.velocity,
            ],
            gain: servo.b * sample_time * sample_time,
            mode: mode.map(|mode| SampledMode::new(mode, part, sample_time)),
            slowed: [0.0; 2],
        }
    }

    /// The response of a servo with a mode of a resonance's kind.
    pub(super) fn of(
        resonance: &Resonance,
        servo: &PossibleServo,
        mode: &Mode,
        sample_time: f64,
    ) -> Self {
        if resonance.friction_on_motor {
            Self::with_friction_on_motor(servo, mode, sample_time)
        } else {
            Self::new(servo, Some(mode), sample_time)
        }
    }

    /// The response of two masses whose viscous friction is the motor's. Friction is a feedback of the motor's velocity:
    ///
    /// G/b = N/(s (s³ + (2ζω + a (1 + β)) s² + (ω² + 2ζωa) s + aω²)), N = (1 + β) s² + 2ζωs + ω²,
    ///
    /// with a real pole −p and those of the mode. It is p/a of 1/(s (s + p)), the mode r/(s − s₁) and its conjugate, and
    /// −2 Re r/(s + p), which friction that is small beside ω leaves out. The sum alone serves where a mode does not
    /// oscillate.
    #[must_use]
    pub fn with_friction_on_motor(servo: &PossibleServo, mode: &Mode, sample_time: f64) -> Self {
        const STEPS: usize = 30;
        let sum = Self::new(servo, Some(mode), sample_time);
        let (a, square) = (servo.a, mode.frequency * mode.frequency);
        let damped = 2.0 * mode.damping * mode.frequency;
        let [c2, c1, c0] = [
            damped + a * (1.0 + mode.ratio),
            square + damped * a,
            a * square,
        ];
        let mut p = c0 / c1;
        for _ in 0..STEPS {
            let value = ((c2 - p) * p - c1) * p + c0;
            let slope = (2.0 * c2 - 3.0 * p) * p - c1;
            p -= value / slope;
        }
        let (sum_of_poles, product) = (c2 - p, c1 - p * (c2 - p));
        let imaginary = product - 0.25 * sum_of_poles * sum_of_poles;
        let is_slow = (0.0..=ZeroOrderHoldStep::<f64>::LARGEST_RATE).contains(&(p * sample_time));
        let oscillates = imaginary > 0.0;
        if !(is_slow && oscillates) {
            return sum;
        }
        let s = Complex::new(-0.5 * sum_of_poles, libm::sqrt(imaginary));
        let numerator = (s * s).scaled(1.0 + mode.ratio) + s.scaled(damped) + square;
        let others = s * (s + p) * Complex::new(0.0, 2.0 * s.im);
        let residue = (numerator / others).scaled(2.0);
        let (_, part) = split(servo.delay / sample_time);
        let rigid = PossibleServo { a: p, ..*servo };
        let own = Self::new(&rigid, None, sample_time);
        // Of 1/(s (s + p)) the velocity is what 1/(s + p) moves.
        let slowed = -residue.re / sample_time;
        // Both of G/b per T², where those of the first have p/a.
        let first = square / product;
        Self {
            newer: own.newer.map(|newer| first * newer),
            older: own.older.map(|older| first * older),
            slowed: [slowed * own.newer[1], slowed * own.older[1]],
            mode: Some(SampledMode::of(s, residue, part, sample_time)),
            ..own
        }
    }

    /// In single precision, for responses as rough as measured ones.
    #[must_use]
    pub fn single(&self) -> SampledServo<f32> {
        SampledServo {
            whole_delay: self.whole_delay,
            decay: f32::from_f64(self.decay),
            h1: f32::from_f64(self.h1),
            newer: self.newer.map(Number::from_f64),
            older: self.older.map(Number::from_f64),
            gain: f32::from_f64(self.gain),
            mode: self.mode.as_ref().map(SampledMode::single),
            slowed: self.slowed.map(Number::from_f64),
        }
    }

    /// The position per command, rad per command unit, at ν = tan(ωT/2) above zero.
    #[must_use]
    pub fn at(&self, nu: f64) -> Complex {
        self.at_delta(delta_at(nu))
    }

    /// The ν at which it resonates, and the resonance's width; none for one mass.
    #[must_use]
    pub fn resonance(&self) -> Option<(f64, f64)> {
        self.mode.as_ref().map(SampledMode::resonance)
    }

    /// Its numerator at z = 1.
    fn at_rest(&self) -> f64 {
        let [newer, older] = [self.newer, self.older];
        self.decay * (newer[0] + older[0]) + self.h1 * (newer[1] + older[1])
    }

    /// What a mode would add to that.
    pub(super) fn of_mode(&self, mode: &SampledMode, nu: f64) -> Complex {
        let delta = delta_at(nu);
        let late = (delta + 1.0).raised(self.whole_delay + 1).conjugate();
        (mode.at(delta) * late).scaled(self.gain)
    }
}

impl SampledServo<f32> {
    /// With the mode of a second mass behind the delay that it was built with, s: a mode alone takes half of the time of
    /// both.
    #[must_use]
    pub fn with_mode(self, delay: f64, mode: &Mode, sample_time: f64) -> Self {
        let (_, part) = split(delay / sample_time);
        Self {
            mode: Some(SampledMode::new(mode, part, sample_time).single()),
            ..self
        }
    }
}

impl<N: Number> SampledServo<N> {
    /// The response over b T², times δ (δ + x h₁).
    fn numerator(&self, delta: Complex<N>) -> Complex<N> {
        let z = delta + N::ONE;
        let [newer_displacement, newer_velocity] = self.newer;
        let [older_displacement, older_velocity] = self.older;
        let slowing = delta + self.decay;
        let displacement = z.scaled(newer_displacement) + older_displacement;
        let velocity = z.scaled(newer_velocity) + older_velocity;
        let together = slowing * displacement + velocity.scaled(self.h1);
        let servo = match &self.mode {
            Some(mode) => {
                let [newer, older] = self.slowed;
                let both = slowing * mode.at(delta) + z.scaled(newer) + older;
                together + delta * both
            }
            None => together,
        };
        // On the unit circle 1/z is the conjugate.
        servo * z.raised(self.whole_delay + 1).conjugate()
    }

    /// The position per command, rad per command unit, at δ = e^(jωT) − 1 other than zero.
    #[must_use]
    pub fn at_delta(&self, delta: Complex<N>) -> Complex<N> {
        self.numerator(delta).scaled(self.gain) / (delta * (delta + self.decay))
    }
}

impl SampledController {
    fn new(design: &Design, sample_time: f64, factor: f64) -> Self {
        let filter = -libm::expm1(-design.cutoff * sample_time);
        Self {
            filter,
            gains: [
                factor * design.kp,
                factor * design.kd / sample_time * filter,
                factor * design.ki * sample_time,
            ],
            notch: nu_at(design.notch, sample_time),
        }
    }

    /// The response times δ (δ + g), at ν.
    fn numerator(&self, nu: f64, delta: Complex) -> Complex {
        let [proportional, derivative, integral] = self.gains;
        let filtered = delta + self.filter;
        let pid = (delta * filtered).scaled(proportional)
            + (delta * delta).scaled(derivative)
            + filtered.scaled(integral);
        match self.notch {
            Some(notch) => pid * notch_at(notch, nu),
            None => pid,
        }
    }

    /// The command per error at ν, command units per rad.
    pub(super) fn of(design: &Design, sample_time: f64, nu: f64) -> Complex {
        let controller = Self::new(design, sample_time, 1.0);
        let delta = delta_at(nu);
        controller.numerator(nu, delta) / (delta * (delta + controller.filter))
    }
}

impl SampledResponse {
    /// The loop around a servo of one mass or of two.
    pub(super) fn around(design: &Design, servo: SampledServo, sample_time: f64) -> Self {
        Self {
            servo,
            controller: SampledController::new(design, sample_time, servo.gain),
        }
    }

    /// At ν = tan(ωT/2).
    pub(super) fn at(&self, nu: f64) -> Point {
        let delta = delta_at(nu);
        let slowing = delta + self.servo.decay;
        let filtered = delta + self.controller.filter;
        Point {
            open: delta * delta * slowing * filtered,
            forward: self.servo.numerator(delta) * self.controller.numerator(nu, delta),
        }
    }

    /// The characteristic function at z = 1, where it is real.
    pub(super) fn at_rest(&self) -> f64 {
        let [_, _, integral] = self.controller.gains;
        self.servo.at_rest() * integral * self.controller.filter
    }

    /// The ν at which the servo resonates, and the resonance's width.
    pub(super) fn resonance(&self) -> Option<(f64, f64)> {
        self.servo.resonance()
    }
}

impl Point {
    /// L.
    pub(super) fn gain(&self) -> Complex {
        self.forward / self.open
    }
}

/// Whole samples of a delay and the part beyond them.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "delays are bounded, and not negative"
)]
pub(super) fn split(delay: f64) -> (u32, f64) {
    let whole = libm::floor(delay);
    (whole as u32, delay - whole)
}
