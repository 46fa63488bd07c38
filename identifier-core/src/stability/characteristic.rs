//! The characteristic polynomial of the sampled loop: exact, and linear in the servo's b.
//!
//! The servo with its hold is b T² (h₁ + h₂ δ)/(δ (δ + x h₁)). Here δ = z − 1 and x = a T; h₁ and h₂ are those of
//! [`ZeroOrderHoldStep`](crate::model::ZeroOrderHoldStep). The velocity filter on the increment is n(z) δ/(z (z − p)).
//! The integral is 1/δ; without integral action that factor cancels.
//!
//! Tustin's w, with z = (1 + w)/(1 − w), maps the unit circle onto the left half plane. Every factor of the polynomial
//! is linear in δ, and so in w once it is multiplied by 1 − w. Then z becomes 1 + w, δ becomes 2 w, and c + l δ becomes
//! c + (2 l − c) w. The polynomial is therefore multiplied out in w. At high rates its roots crowd at w = 0, and only
//! their distance from there carries digits.

use super::hurwitz::{DEGREE, Polynomial};
use crate::control::Gains;
use crate::measurement::velocity::Transfer;
use crate::units::Units;

/// The part of the polynomial that does not depend on the servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ControllerPolynomials {
    /// The factor of the servo's pole: z δ (z − p), with integral action times δ.
    poles: Part,
    /// The factor of the servo's zero: T² times the controller's numerator, times 1 − w for the servo's missing zero.
    zeros: Part,
    degree: usize,
    /// The sample time T, s.
    rate: f64,
}

/// The polynomials of all servos of one a, as a function of b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Family {
    pub(super) open: Whole,
    /// Per b, rad/s² per command unit.
    pub(super) per_gain: Whole,
    pub(super) degree: usize,
}

/// Coefficients, lowest power of w first.
type Linear = [f64; 2];
type Part = [f64; DEGREE];
type Whole = [f64; DEGREE + 1];

/// c + l δ.
fn linear(constant: f64, slope: f64) -> Linear {
    [constant, 2.0 * slope - constant]
}

impl ControllerPolynomials {
    /// The controller of the loop; or the correction in command form, whose error obeys the same
    /// equation.
    pub(super) fn new(units: &Units, gains: &Gains, velocity: &Transfer) -> Self {
        let rate = units.rate();
        let (one, z, delta) = (linear(1.0, 0.0), linear(1.0, 1.0), linear(0.0, 1.0));
        let filter = linear(1.0 - velocity.pole, 1.0);
        let [constant, slope] = velocity.numerator;
        let derivative = linear(constant + slope, slope);
        let ki = gains.ki() * rate;
        let integrates = ki > 0.0;
        // k_p + k_i T/δ and the damping's share, over the integral's pole if there is one.
        let (integral_pole, position) = if integrates {
            (delta, linear(ki, gains.kp()))
        } else {
            ([1.0, 0.0], [gains.kp(), 0.0])
        };
        let held = rate * rate;
        let damping = gains.kd() / rate;
        let of_position = product([z, filter, position, one]);
        let of_velocity = product([delta, derivative, integral_pole, one]);
        Self {
            poles: product([z, delta, filter, integral_pole]),
            zeros: core::array::from_fn(|k| held * (of_position[k] + damping * of_velocity[k])),
            degree: if integrates { DEGREE } else { DEGREE - 1 },
            rate,
        }
    }

    /// The loop around the servos of one a, 1/s.
    pub(super) fn around(&self, a: f64) -> Family {
        let x = a * self.rate;
        let h2 = if libm::fabs(x) < 1e-4 {
            0.5 - x / 6.0
        } else {
            (x + libm::expm1(-x)) / (x * x)
        };
        let h1 = 1.0 - x * h2;
        Family {
            open: times(&self.poles, linear(x * h1, 1.0)),
            per_gain: times(&self.zeros, linear(h1, h2)),
            degree: self.degree,
        }
    }
}

impl Family {
    /// The polynomial of a servo's b, rad/s² per command unit.
    pub(super) fn at(&self, b: f64) -> Polynomial {
        Polynomial {
            coefficients: core::array::from_fn(|k| self.open[k] + b * self.per_gain[k]),
            degree: self.degree,
        }
    }
}

fn product(factors: [Linear; DEGREE - 1]) -> Part {
    let one = core::array::from_fn(|k| if k == 0 { 1.0 } else { 0.0 });
    factors
        .into_iter()
        .fold(one, |sum: Part, factor| times(&sum, factor))
}

/// The product. Coefficients beyond M are zero by the degrees of the factors.
fn times<const N: usize, const M: usize>(
    polynomial: &[f64; N],
    [constant, slope]: Linear,
) -> [f64; M] {
    let of = |k: Option<usize>| k.and_then(|k| polynomial.get(k)).copied().unwrap_or(0.0);
    core::array::from_fn(|k| constant * of(Some(k)) + slope * of(k.checked_sub(1)))
}
