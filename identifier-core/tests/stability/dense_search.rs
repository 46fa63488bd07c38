//! The verdicts on the sampled loop by a dense search: Routh's array at every point of every grid, from
//! the polynomial in δ = z − 1. It shares only the equations with the code under test.

use identifier_core::control::Gains;
use identifier_core::interval::Interval;
use identifier_core::measurement::Transfer;
use identifier_core::stability::{ParameterRange, SampledLoop};
use identifier_core::units::Units;

/// Points of the grid along each side of the box.
const GRID: u32 = 17;

/// A loop, or a correction, that is searched, and the box that it is for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DenseSearch {
    pub(crate) units: Units,
    pub(crate) gains: Gains,
    pub(crate) velocity: Transfer,
    /// Factor on every b, to measure the distance of a verdict from its edge.
    pub(crate) gain: f64,
    pub(crate) range: ParameterRange,
}

impl DenseSearch {
    /// The loop under test.
    pub(crate) fn sampled(&self) -> SampledLoop {
        SampledLoop::new(&self.units, &self.gains, &self.velocity)
    }

    /// The first servo (a, b) on the grid over a box that is not stable.
    pub(crate) fn check(&self) -> Option<(f64, f64)> {
        let (a, b) = (self.range.a(), self.range.b());
        let ratio = (b.max() / b.min()).powf(1.0 / f64::from(GRID - 1));
        let mut gain = b.min();
        for _ in 0..GRID {
            for i in 0..GRID {
                if !self.is_stable(on_grid(a, i), gain) {
                    return Some((on_grid(a, i), gain));
                }
            }
            gain *= ratio;
        }
        None
    }

    /// The factor by which b_max may grow.
    pub(crate) fn gain_margin(&self) -> f64 {
        let stable = |factor: f64| {
            let b = factor * self.range.b().max();
            (0..GRID).all(|i| self.is_stable(on_grid(self.range.a(), i), b))
        };
        let mut margin = 1.0;
        while margin < 2.0 * SampledLoop::AMPLE_GAIN_MARGIN && stable(margin * 1.05) {
            margin *= 1.05;
        }
        margin
    }

    /// The largest estimate that is allowed.
    pub(crate) fn most_gain(&self, nominal: f64) -> f64 {
        let mut most = nominal;
        for _ in 0..200 {
            let next = most * 1.1;
            if !self.is_stable(0.0, SampledLoop::AMPLE_GAIN_MARGIN * next) {
                break;
            }
            most = next;
        }
        most
    }

    /// The last estimate that is stable, if one of those on the grid is not.
    pub(crate) fn check_estimates(&self, from: f64, to: f64) -> Option<f64> {
        let ratio = (to / from).powf(1.0 / f64::from(GRID - 1));
        let (mut gain, mut stable) = (from, 0.0);
        for _ in 0..GRID {
            if !self.is_stable(0.0, gain) {
                return Some(stable);
            }
            stable = gain;
            gain *= ratio;
        }
        None
    }

    /// True if the sampled loop around one servo is stable.
    pub(crate) fn is_stable(&self, a: f64, b: f64) -> bool {
        is_schur(self.characteristic_polynomial(a, b))
    }

    /// The closed loop's characteristic polynomial in δ and its degree.
    ///
    /// The servo held over a sample is b T² (h₁ + h₂ δ)/(δ (δ + x h₁)) with x = a T, h₁ and h₂ as in
    /// `ZeroOrderHoldStep`; the velocity filter on the increment is
    /// n(z) δ/(z (z − p)); the integral is 1/δ. Without integral action that last factor cancels.
    fn characteristic_polynomial(&self, a: f64, b: f64) -> (Polynomial, usize) {
        let (rate, b) = (self.units.rate(), self.gain * b);
        let x = a * rate;
        let exact = (x + (-x).exp_m1()) / (x * x);
        let h2 = if x.abs() < 1e-4 { 0.5 - x / 6.0 } else { exact };
        let h1 = 1.0 - x * h2;
        let gain = b * rate * rate;
        let kd = self.gains.kd() / rate;
        let ki = self.gains.ki() * rate;

        let z = [1.0, 1.0];
        let delta = [0.0, 1.0];
        let servo = [gain * h1, gain * h2];
        let filter = [1.0 - self.velocity.pole, 1.0];
        let [constant, linear] = self.velocity.numerator;
        let derivative = [constant + linear, linear];

        let open = product(&[z, delta, [x * h1, 1.0], filter]);
        let proportional = scaled(self.gains.kp(), product(&[z, filter, servo]));
        let damping = scaled(kd, product(&[delta, derivative, servo]));
        let without_integral = sum(open, sum(proportional, damping));
        if ki > 0.0 {
            let integral = scaled(ki, product(&[z, filter, servo]));
            (sum(times(without_integral, delta), integral), DEGREE)
        } else {
            (without_integral, DEGREE - 1)
        }
    }
}

fn on_grid(interval: Interval, i: u32) -> f64 {
    interval.min() + (interval.max() - interval.min()) * f64::from(i) / f64::from(GRID - 1)
}

/// Degree of the characteristic polynomial: position, velocity, integral, filter pole and the
/// filter's last increment.
const DEGREE: usize = 5;

/// Coefficients, lowest power first.
type Polynomial = [f64; DEGREE + 1];

fn times(polynomial: Polynomial, [constant, linear]: [f64; 2]) -> Polynomial {
    std::array::from_fn(|k| {
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
    std::array::from_fn(|k| x[k] + y[k])
}

/// True if all roots in δ lie inside |1 + δ| < 1.
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
        std::array::from_fn(|k| match (degree + 1).checked_sub(first + 2 * k + 1) {
            Some(power) => p[power],
            None => 0.0,
        })
    };
    let (mut upper, mut lower) = (row(0), row(1));
    for _ in 0..degree {
        // A NaN is not positive either.
        if !(upper[0] > 0.0 && lower[0] > 0.0) {
            return false;
        }
        let ratio = upper[0] / lower[0];
        let mut next = [0.0; DEGREE + 1];
        for k in 0..DEGREE {
            next[k] = upper[k + 1] - ratio * lower[k + 1];
        }
        (upper, lower) = (lower, next);
    }
    upper[0] > 0.0
}
