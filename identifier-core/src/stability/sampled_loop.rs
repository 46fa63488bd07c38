//! What sampling takes away: the poles of the sampled loop over the box.
//!
//! The certificate is about continuous time. The loop that runs holds its command for a sample,
//! filters its velocity and sums its integral; too long a sample or too slow a filter makes it
//! unstable however well (14) holds. Here its characteristic polynomial, exact for the sampled
//! loop, is tested for roots inside the unit circle (Schur–Cohn recursion) on a grid over the box,
//! ends included. A grid is not a proof between its points; the roots move continuously, and the
//! grid is fine (geometric in b, as the gain acts).

use core::fmt;

use super::PlantBox;
use crate::control::Gains;
use crate::measurement::velocity::Transfer;
use crate::units::Units;

/// A servo of the box whose sampled loop is not stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledLoopError {
    /// Its a, 1/s.
    pub a: f64,
    /// Its b, rad/s² per command unit.
    pub b: f64,
    /// The sample time, s.
    pub sample_time: f64,
}

impl fmt::Display for SampledLoopError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the sampled loop is unstable for the servo a = {:.6}, b = {:.6}: sample faster than \
             {} s, raise the cut-off of the velocity filter, lower the gains, or shrink the box",
            self.a, self.b, self.sample_time
        )
    }
}

impl core::error::Error for SampledLoopError {}

/// Points of the grid along each side of the box.
const GRID: u32 = 17;

/// Checks the sampled loop of every servo on a grid over the box.
///
/// # Errors
/// The first servo whose loop has a root on or outside the unit circle.
pub fn check(
    units: &Units,
    gains: &Gains,
    velocity: &Transfer,
    plant_box: &PlantBox,
) -> Result<(), SampledLoopError> {
    let (a, b) = (plant_box.a(), plant_box.b());
    let step = f64::from(GRID - 1);
    let ratio = libm::pow(b.max() / b.min(), 1.0 / step);
    let mut gain = b.min();
    for _ in 0..GRID {
        for i in 0..GRID {
            let rate = a.min() + (a.max() - a.min()) * f64::from(i) / step;
            if !is_stable(units, gains, velocity, rate, gain) {
                return Err(SampledLoopError {
                    a: rate,
                    b: gain,
                    sample_time: units.sample_time(),
                });
            }
        }
        gain *= ratio;
    }
    Ok(())
}

/// Whether the sampled loop around one servo (a in 1/s, b in rad/s² per command unit) is stable.
#[must_use]
pub fn is_stable(units: &Units, gains: &Gains, velocity: &Transfer, a: f64, b: f64) -> bool {
    schur_stable(characteristic_polynomial(units, gains, velocity, a, b))
}

/// Degree of the characteristic polynomial: position, velocity, integral, filter pole and the
/// filter's last increment.
const DEGREE: usize = 5;

type Polynomial = [f64; DEGREE + 1];

/// z (z − 1)·A(z)·(z − p) + B(z)·[k_p (z − 1)(z − p) z + k_i z (z − p) + k_d (z − 1)² n(z)],
/// where B/A = (h₁² + h₂ (z − E))/((z − 1)(z − E))·b is the servo held over a sample and n/(z − p)
/// the velocity filter on the increment (1 − z⁻¹) q. Without integral action the factor (z − 1) of
/// the integral cancels.
fn characteristic_polynomial(
    units: &Units,
    gains: &Gains,
    velocity: &Transfer,
    a: f64,
    b: f64,
) -> (Polynomial, usize) {
    let x = a * units.rate();
    let h2 = if libm::fabs(x) < 1e-4 {
        0.5 - x / 6.0
    } else {
        (x + libm::expm1(-x)) / (x * x)
    };
    let h1 = 1.0 - x * h2;
    let decayed = 1.0 - x * h1;
    let gain = b * units.rate() * units.rate();
    let pole = velocity.pole;
    let numerator = [gain * (h1 * h1 - h2 * decayed), gain * h2];
    let kd = gains.kd() / units.rate();
    let ki = gains.ki() * units.rate();

    let integrating = ki > 0.0;
    let open = product(&[[0.0, 1.0], [-1.0, 1.0], [-decayed, 1.0], [-pole, 1.0]]);
    let proportional = scaled(gains.kp(), product(&[[0.0, 1.0], [-pole, 1.0], numerator]));
    let derivative = scaled(kd, product(&[[-1.0, 1.0], velocity.numerator, numerator]));
    let mut closed = sum(open, sum(proportional, derivative));
    if integrating {
        let integral = scaled(ki, product(&[[0.0, 1.0], [-pole, 1.0], numerator]));
        closed = sum(times(closed, [-1.0, 1.0]), integral);
    }
    (closed, if integrating { DEGREE } else { DEGREE - 1 })
}

fn times(polynomial: Polynomial, [constant, linear]: [f64; 2]) -> Polynomial {
    core::array::from_fn(|k| {
        let lower = if k == 0 { 0.0 } else { polynomial[k - 1] };
        constant * polynomial[k] + linear * lower
    })
}

fn product(factors: &[[f64; 2]]) -> Polynomial {
    let mut one = [0.0; DEGREE + 1];
    one[0] = 1.0;
    factors.iter().fold(one, |sum, &factor| times(sum, factor))
}

fn scaled(factor: f64, polynomial: Polynomial) -> Polynomial {
    polynomial.map(|coefficient| factor * coefficient)
}

fn sum(x: Polynomial, y: Polynomial) -> Polynomial {
    core::array::from_fn(|k| x[k] + y[k])
}

/// Schur–Cohn: a polynomial has all roots inside the unit circle exactly when |p₀| < |pₙ| and the
/// reduced polynomial (pₙ p(z) − p₀ p*(z))/z, of one degree less, has.
fn schur_stable((mut p, degree): (Polynomial, usize)) -> bool {
    for n in (1..=degree).rev() {
        let (first, last) = (p[0], p[n]);
        let inside = libm::fabs(first) < libm::fabs(last);
        if !inside {
            return false;
        }
        let k = first / last;
        let reflected: Polynomial = core::array::from_fn(|i| if i <= n { p[n - i] } else { 0.0 });
        for i in 0..n {
            p[i] = p[i + 1] - k * reflected[i + 1];
        }
        p[n] = 0.0;
    }
    true
}
