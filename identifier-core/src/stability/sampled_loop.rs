//! What sampling takes away: the poles of the sampled loop over the box.
//!
//! The certificate is about continuous time. The loop that runs holds its command for a sample,
//! filters its velocity and sums its integral; too long a sample or too slow a filter makes it
//! unstable however well (14) holds. Here its characteristic polynomial, exact for the sampled
//! loop, is tested for roots inside the unit circle on a grid over the box, ends included. A grid
//! is not a proof between its points; the roots move continuously, and the grid is fine (geometric
//! in b, as the gain acts).
//!
//! The polynomial is written in δ = z − 1: at high rates its roots crowd at z = 1, and only their
//! distance from there carries digits. Tustin's w, with δ = 2w/(1 − w), then maps the unit circle
//! onto the left half plane, where Routh's array decides.

use core::fmt;

use super::PlantBox;
use crate::control::Gains;
use crate::interval::Interval;
use crate::measurement::velocity::Transfer;
use crate::units::Units;

/// A servo of the box whose sampled loop is not stable.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
             every {} s, raise the cut-off of the velocity filter, lower the gains, or shrink the box",
            self.a, self.b, self.sample_time
        )
    }
}

impl core::error::Error for SampledLoopError {}

/// Points of the grid along each side of the box.
const GRID: u32 = 17;

/// The gain margin from which on sampling is no concern: see [`gain_margin`].
pub const AMPLE_GAIN_MARGIN: f64 = 4.0;

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
    let ratio = libm::pow(b.max() / b.min(), 1.0 / f64::from(GRID - 1));
    let mut gain = b.min();
    for _ in 0..GRID {
        for i in 0..GRID {
            let rate = on_grid(a, i);
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

/// The factor by which b_max could grow before the sampled loop of some servo on the grid becomes
/// unstable, at most twice [`AMPLE_GAIN_MARGIN`].
///
/// A loop near its edge answers at frequencies where hold and filter delay the output error so far
/// that (11) is no longer passive: the estimates can then wander although the loop is stable. With
/// an ample margin none of 300 random certified loops does under a Γ from a tenth of to ten times
/// the automatic one; below it some do (`cargo test --test certificate`).
#[must_use]
pub fn gain_margin(units: &Units, gains: &Gains, velocity: &Transfer, plant_box: &PlantBox) -> f64 {
    /// Ratio of successive factors.
    const STEP: f64 = 1.05;
    let stable = |factor: f64| {
        (0..GRID).all(|i| {
            let a = on_grid(plant_box.a(), i);
            is_stable(units, gains, velocity, a, factor * plant_box.b().max())
        })
    };
    let mut margin = 1.0;
    while margin < 2.0 * AMPLE_GAIN_MARGIN && stable(margin * STEP) {
        margin *= STEP;
    }
    margin
}

/// The largest b̂ that the correction in command form is given where nobody bounds it: a
/// [`AMPLE_GAIN_MARGIN`] below where the sampled correction becomes unstable, but the largest b that
/// the servo may have, `nominal`, at least.
#[must_use]
pub fn most_gain(units: &Units, gains: &Gains, velocity: &Transfer, nominal: f64) -> f64 {
    /// Ratio of successive values.
    const STEP: f64 = 1.1;
    /// Values that are tried: a range of 10⁸.
    const MOST: u32 = 200;
    let mut most = nominal;
    for _ in 0..MOST {
        let next = most * STEP;
        if !is_stable(units, gains, velocity, 0.0, AMPLE_GAIN_MARGIN * next) {
            break;
        }
        most = next;
    }
    most
}

/// Checks the sampled correction in command form for the largest estimates b̂, from `from` to `to`.
///
/// The output error obeys the same equation as the loop of a servo with the parameters of the
/// *estimate* under a PID with the correction's gains, so what sampling asks of the loop over the
/// servo's box it asks of the correction over what the estimates may be. Only large b̂ make it
/// unstable by sampling.
///
/// # Errors
/// The smallest b̂ on a geometric grid whose correction is unstable.
pub fn check_estimates(
    units: &Units,
    gains: &Gains,
    velocity: &Transfer,
    from: f64,
    to: f64,
) -> Result<(), EstimateError> {
    let ratio = libm::pow(to / from, 1.0 / f64::from(GRID - 1));
    let mut gain = from;
    let mut stable = 0.0;
    for _ in 0..GRID {
        if !is_stable(units, gains, velocity, 0.0, gain) {
            return Err(EstimateError {
                b: to,
                stable,
                sample_time: units.sample_time(),
            });
        }
        stable = gain;
        gain *= ratio;
    }
    Ok(())
}

/// A bound of the estimates at which the sampled correction is not stable.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EstimateError {
    /// The largest b̂ that the bounds allow, rad/s² per command unit.
    pub b: f64,
    /// The largest on the grid that would do; zero for none.
    pub stable: f64,
    /// The sample time, s.
    pub sample_time: f64,
}

impl fmt::Display for EstimateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the model's correction, sampled every {} s, is unstable for an estimate b = {:.6}: bound b \
             by {:.6}, sample faster, raise the cut-off of the velocity filter, or lower the gains",
            self.sample_time, self.b, self.stable
        )
    }
}

impl core::error::Error for EstimateError {}

/// The i-th value of the grid over an interval.
fn on_grid(interval: Interval, i: u32) -> f64 {
    interval.min() + (interval.max() - interval.min()) * f64::from(i) / f64::from(GRID - 1)
}

/// Whether the sampled loop around one servo (a in 1/s, b in rad/s² per command unit) is stable.
#[must_use]
pub fn is_stable(units: &Units, gains: &Gains, velocity: &Transfer, a: f64, b: f64) -> bool {
    is_schur(characteristic_polynomial(units, gains, velocity, a, b))
}

/// Degree of the characteristic polynomial: position, velocity, integral, filter pole and the
/// filter's last increment.
const DEGREE: usize = 5;

/// Coefficients, lowest power first.
type Polynomial = [f64; DEGREE + 1];

/// The closed loop's characteristic polynomial in δ and its degree.
///
/// The servo held over a sample is b T² (h₁ + h₂ δ)/(δ (δ + x h₁)) with x = a T, h₁ and h₂ as in
/// [`HeldStep`](crate::model::HeldStep); the velocity filter on the increment is
/// n(z) δ/(z (z − p)); the integral is 1/δ. Without integral action that last factor cancels.
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
    let gain = b * units.rate() * units.rate();
    let kd = gains.kd() / units.rate();
    let ki = gains.ki() * units.rate();

    let z = [1.0, 1.0];
    let delta = [0.0, 1.0];
    let servo = [gain * h1, gain * h2];
    let filter = [1.0 - velocity.pole, 1.0];
    let [constant, linear] = velocity.numerator;
    let derivative = [constant + linear, linear];

    let open = product(&[z, delta, [x * h1, 1.0], filter]);
    let proportional = scaled(gains.kp(), product(&[z, filter, servo]));
    let damping = scaled(kd, product(&[delta, derivative, servo]));
    let without_integral = sum(open, sum(proportional, damping));
    if ki > 0.0 {
        let integral = scaled(ki, product(&[z, filter, servo]));
        (sum(times(without_integral, delta), integral), DEGREE)
    } else {
        (without_integral, DEGREE - 1)
    }
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

/// Whether all roots in δ lie inside |1 + δ| < 1.
fn is_schur((p, degree): (Polynomial, usize)) -> bool {
    let mut mapped = [0.0; DEGREE + 1];
    for (k, &coefficient) in p.iter().enumerate().take(degree + 1) {
        // c δᵏ becomes c (2w)ᵏ (1 − w)ⁿ⁻ᵏ once multiplied by (1 − w)ⁿ.
        let mut factors = [[1.0, 0.0]; DEGREE];
        for (i, factor) in factors.iter_mut().enumerate().take(degree) {
            *factor = if i < k { [0.0, 2.0] } else { [1.0, -1.0] };
        }
        mapped = sum(mapped, scaled(coefficient, product(&factors)));
    }
    is_hurwitz(&mapped, degree)
}

/// Routh's criterion: all roots lie in the left half plane exactly when the first column of the
/// array is positive (leading coefficient positive).
fn is_hurwitz(p: &Polynomial, degree: usize) -> bool {
    let row = |first: usize| -> Polynomial {
        core::array::from_fn(|k| match (degree + 1).checked_sub(first + 2 * k + 1) {
            Some(power) => p[power],
            None => 0.0,
        })
    };
    let (mut upper, mut lower) = (row(0), row(1));
    for _ in 0..degree {
        let positive = upper[0] > 0.0 && lower[0] > 0.0;
        if !positive {
            return false;
        }
        let ratio = upper[0] / lower[0];
        let next = core::array::from_fn(|k| {
            if k < DEGREE {
                upper[k + 1] - ratio * lower[k + 1]
            } else {
                0.0
            }
        });
        (upper, lower) = (lower, next);
    }
    upper[0] > 0.0
}
