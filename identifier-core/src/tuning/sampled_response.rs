//! The frequency response of the sampled loop, exact: held command, fractional delay, velocity estimate and
//! sum as they run.
//!
//! With δ = z − 1, x = a T, and h₁, h₂ as in [`ZeroOrderHoldStep`], the servo per command, in rad, is
//!
//! b T² z^−(m+1) ((δ + x h₁)(q₁ z + q₀) + h₁ (v₁ z + v₀)) / (δ (δ + x h₁)),
//!
//! where the delay is m whole samples and a part φ of one: q₁ and v₁ are what a command adds to position
//! and velocity over the last 1 − φ of a sample, q₀ = h₂ − q₁ and v₀ = h₁ − v₁ what the command before
//! adds. The controller is k_p + (k_d/T) g δ/(δ + g) + k_i T/δ, g = 1 − e^(−cutoff T).
//!
//! Frequencies are taken along Tustin's z = (1 + jν)/(1 − jν), ν = tan(ωT/2), so that no point needs a
//! transcendental function, and δ = 2jν/(1 − jν) keeps all its digits where z is near one.

use super::placement::Design;
use super::possible_servos::PossibleServo;
use crate::model::ZeroOrderHoldStep;
use crate::number::Complex;

/// The loop of a design around a servo, opened at the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SampledResponse {
    whole_delay: u32,
    /// x h₁.
    decay: f64,
    h1: f64,
    /// Position and velocity that a command adds in its first sample.
    newer: [f64; 2],
    /// Position and velocity that it adds in the sample after that.
    older: [f64; 2],
    filter: f64,
    /// The controller's gains times b T²: k_p, k_d/T g, k_i T.
    gains: [f64; 3],
}

/// The loop at a frequency: L = forward/open, and the characteristic function open + forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// δ² (δ + x h₁)(δ + g).
    pub(super) open: Complex,
    pub(super) forward: Complex,
}

impl SampledResponse {
    pub(super) fn new(design: &Design, servo: &PossibleServo, sample_time: f64) -> Self {
        let step = ZeroOrderHoldStep::<f64>::new();
        let x = servo.a * sample_time;
        let (whole_delay, part) = split(servo.delay / sample_time);
        let held = step.response(x);
        let newest = step.partial_response(x, 1.0 - part);
        let gain = servo.b * sample_time * sample_time;
        let filter = -libm::expm1(-design.cutoff * sample_time);
        Self {
            whole_delay,
            decay: x * held.velocity,
            h1: held.velocity,
            newer: [newest.way, newest.velocity],
            older: [held.way - newest.way, held.velocity - newest.velocity],
            filter,
            gains: [
                gain * design.kp,
                gain * design.kd / sample_time * filter,
                gain * design.ki * sample_time,
            ],
        }
    }

    /// At ν = tan(ωT/2).
    pub(super) fn at(&self, nu: f64) -> Point {
        let sine = 2.0 * nu / (1.0 + nu * nu);
        let delta = Complex {
            re: -nu * sine,
            im: sine,
        };
        let z = delta + 1.0;
        let [newer_way, newer_velocity] = self.newer;
        let [older_way, older_velocity] = self.older;
        let [proportional, derivative, integral] = self.gains;
        let slowing = delta + self.decay;
        let filtered = delta + self.filter;
        let squared = delta * delta;
        let way = z.scaled(newer_way) + older_way;
        let velocity = z.scaled(newer_velocity) + older_velocity;
        let servo = slowing * way + velocity.scaled(self.h1);
        let controller = (delta * filtered).scaled(proportional)
            + squared.scaled(derivative)
            + filtered.scaled(integral);
        // On the unit circle 1/z is the conjugate.
        let delayed = z.raised(self.whole_delay + 1).conjugate();
        Point {
            open: squared * slowing * filtered,
            forward: servo * controller * delayed,
        }
    }

    /// The characteristic function at z = 1, where it is real.
    pub(super) fn at_rest(&self) -> f64 {
        let [_, _, integral] = self.gains;
        self.h1 * integral * self.filter
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
