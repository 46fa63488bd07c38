//! The stability lost by sampling: the poles of the sampled loop over the parameter range.
//!
//! The certificate is about continuous time. The loop that runs holds its command for a sample, filters its velocity
//! and sums its integral. Too long a sample or too slow a filter makes it unstable however well (14) holds. The test is
//! that all roots of the exact characteristic polynomial lie inside the unit circle. It is made on a grid over the
//! parameter range, ends included. The grid is geometric in b, as b acts as a gain.
//!
//! The polynomial is linear in b. Along a line of one a one proof covers a segment of the grid, all values between its
//! points included. If the proof fails, the segment is halved, down to single points. The result is that of the whole
//! grid, but for rounding. If the two differ, b is within 10⁻¹¹ (relative) of the stability limit (`cargo test -p
//! identifier-core --test stability sampled_loop::`). From one a to the next nothing is proved; the roots move
//! continuously, and the grid is fine.

use thiserror::Error;

use super::characteristic::{ControllerPolynomials, Family};
use crate::control::Gains;
use crate::error::{Allowed, OutOfRange};
use crate::gradient::ParameterRange;
use crate::interval::Interval;
use crate::measurement::velocity::Transfer;
use crate::units::Units;

/// A servo of the parameter range whose sampled loop is not stable.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the sampled loop is unstable for the servo a = {a:.6}, b = {b:.6}: sample faster than every {sample_time} s, raise \
     the cut-off of the velocity filter, lower the gains, or narrow the parameter range"
)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SampledLoopError {
    /// Its a, 1/s.
    pub a: f64,
    /// Its b, rad/s² per command unit.
    pub b: f64,
    /// The sample time, s.
    pub sample_time: f64,
}

/// Points of the grid along each side of the parameter range.
const GRID: u32 = 17;

/// The sampled loop of a controller around any servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledLoop {
    controller: ControllerPolynomials,
    sample_time: f64,
}

impl SampledLoop {
    /// The gain margin from which on sampling is no concern: see [`SampledLoop::gain_margin`].
    pub const AMPLE_GAIN_MARGIN: f64 = 4.0;

    /// The loop of a PID with these gains and the transfer function of its velocity estimate.
    #[must_use]
    pub fn new(units: &Units, gains: &Gains, velocity: &Transfer) -> Self {
        Self {
            controller: ControllerPolynomials::new(units, gains, velocity),
            sample_time: units.sample_time(),
        }
    }

    /// Checks the sampled loop of every servo on a grid over the parameter range.
    ///
    /// # Errors
    /// The servo whose loop has a root on or outside the unit circle. Among several it is that of the smallest b, then
    /// of the smallest a.
    pub fn check(&self, parameter_range: &ParameterRange) -> Result<(), SampledLoopError> {
        let line = Line::between(parameter_range.b().min(), parameter_range.b().max());
        let mut points = GRID;
        let mut unstable = None;
        for a in grid(parameter_range.a()) {
            let stable = line.stable_points(&self.controller.around(a), points);
            if stable < points {
                points = stable;
                unstable = Some(a);
            }
        }
        match unstable {
            None => Ok(()),
            Some(a) => Err(SampledLoopError {
                a,
                b: line.point(points),
                sample_time: self.sample_time,
            }),
        }
    }

    /// The factor by which b_max could grow before the sampled loop of some servo on the grid becomes unstable. At most
    /// twice [`SampledLoop::AMPLE_GAIN_MARGIN`].
    ///
    /// A loop near its stability limit responds at high frequencies. There hold and filter delay the output error so
    /// far that (11) is no longer passive. The estimates can then wander although the loop is stable. With an ample
    /// margin this happens to none of 300 random certified loops. Their Γ is from a tenth of to ten times the automatic
    /// one. Below that margin it happens to some (`cargo test --test integration certificate::`).
    #[must_use]
    pub fn gain_margin(&self, parameter_range: &ParameterRange) -> f64 {
        /// Ratio of successive factors.
        const STEP: f64 = 1.05;
        /// Factors that are tried: with the last it is twice the ample margin.
        const MAX_FACTORS: u32 = 43;
        let line = Line {
            first: STEP * parameter_range.b().max(),
            ratio: STEP,
        };
        let steps = grid(parameter_range.a()).fold(MAX_FACTORS, |most, a| {
            line.stable_points(&self.controller.around(a), most)
        });
        raised(1.0, STEP, steps)
    }

    /// The largest b̂ of the correction in command form if no bound is given. It is a factor
    /// [`SampledLoop::AMPLE_GAIN_MARGIN`] below the stability limit of the sampled correction. It is not less than
    /// `nominal`, the largest b that the servo may have.
    #[must_use]
    pub fn most_gain(&self, nominal: f64) -> f64 {
        /// Ratio of successive values.
        const STEP: f64 = 1.1;
        /// Values that are tried: a range of 10⁸.
        const MAX_VALUES: u32 = 200;
        let line = Line {
            first: Self::AMPLE_GAIN_MARGIN * (nominal * STEP),
            ratio: STEP,
        };
        let undamped = self.controller.around(0.0);
        raised(nominal, STEP, line.stable_points(&undamped, MAX_VALUES))
    }

    /// Checks the sampled correction in command form for the largest estimates b̂, from `from` to `to`.
    ///
    /// The output error obeys the equation of a servo with the parameters of the *estimate*, under a PID with the
    /// correction's gains. So the correction must be stable over the range of the estimates, as the loop over the
    /// servo's parameter range. Only large b̂ make it unstable by sampling.
    ///
    /// # Errors
    /// The smallest b̂ on a geometric grid whose correction is unstable.
    pub fn check_estimates(&self, from: f64, to: f64) -> Result<(), EstimateError> {
        let line = Line::between(from, to);
        let undamped = self.controller.around(0.0);
        let stable = line.stable_points(&undamped, GRID);
        if stable == GRID {
            return Ok(());
        }
        Err(EstimateError {
            b: to,
            stable: stable.checked_sub(1).map_or(0.0, |last| line.point(last)),
            sample_time: self.sample_time,
        })
    }

    /// True if the sampled loop around one servo (a in 1/s, b in rad/s² per command unit) is stable.
    #[must_use]
    pub fn is_stable(&self, a: f64, b: f64) -> bool {
        self.controller.around(a).at(b).is_hurwitz()
    }
}

/// A bound of the estimates at which the sampled correction is not stable.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the model's correction, sampled every {sample_time} s, is unstable for an estimate b = {b:.6}: bound b by \
     {stable:.6}, sample faster, raise the cut-off of the velocity filter, or lower the gains"
)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EstimateError {
    /// The largest b̂ that the bounds allow, rad/s² per command unit.
    pub b: f64,
    /// The largest on the grid that would do; zero for none.
    pub stable: f64,
    /// The sample time, s.
    pub sample_time: f64,
}

impl EstimateError {
    /// The bound, with its range.
    #[must_use]
    pub const fn out_of_range(&self) -> OutOfRange {
        OutOfRange::new("bounds.b", self.b, Allowed::AtMost(self.stable))
    }
}

/// The grid over a range of a.
fn grid(a: Interval) -> impl Iterator<Item = f64> {
    let step = move |i| a.min() + (a.max() - a.min()) * f64::from(i) / f64::from(GRID - 1);
    (0..GRID).map(step)
}

/// `value` · `ratio`^`steps`. The power is computed step by step, so that a result does not depend on the order of the
/// search.
fn raised(value: f64, ratio: f64, steps: u32) -> f64 {
    (0..steps).fold(value, |value, _| value * ratio)
}

/// Values of b, each by the same ratio above the last.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    first: f64,
    ratio: f64,
}

impl Line {
    /// From one value to another, in the steps of the grid.
    fn between(from: f64, to: f64) -> Self {
        // The root of the sixteenth degree: a power would take two kilobytes on a chip.
        const { assert!(GRID - 1 == 1 << 4) };
        Self {
            first: from,
            ratio: (0..4).fold(to / from, |ratio, _| libm::sqrt(ratio)),
        }
    }

    fn point(&self, index: u32) -> f64 {
        raised(self.first, self.ratio, index)
    }

    /// The number of points, at most `most`, before the first that is not stable.
    fn stable_points(&self, family: &Family, most: u32) -> u32 {
        let mut b = self.first;
        let mut here = family.at(b);
        if most == 0 || !here.is_hurwitz() {
            return 0;
        }
        let (mut stable, mut most) = (1, most);
        let mut stride = most;
        while stable < most {
            stride = stride.min(most - stable);
            let further = raised(b, self.ratio, stride);
            let there = family.at(further);
            if here.stays_hurwitz_up_to(&there) {
                stable += stride;
                (b, here) = (further, there);
                stride *= 2;
            } else if !there.is_hurwitz() {
                // The first that is not is this one or one before.
                most = stable + stride - 1;
                stride = (stride / 2).max(1);
            } else if stride > 1 {
                stride /= 2;
            } else {
                // Two neighbours of the grid, with no proof for the values between them.
                stable += 1;
                (b, here) = (further, there);
            }
        }
        stable
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both ends are Hurwitz, but not everything between them. No loop around a servo is known that behaves so, and the
    /// search must not rely on it.
    #[test]
    fn an_island_is_found_as_point_by_point() {
        let from = [1.0, 0.25, 2.51, 0.2, 1.0, 0.0];
        let to = [0.05, 1.05, 4.6, 8.5, 1.0, 0.0];
        let family = Family {
            open: from,
            per_gain: core::array::from_fn(|k| to[k] - from[k]),
            degree: 4,
        };
        assert!(family.at(0.0).is_hurwitz() && family.at(1.0).is_hurwitz());
        let (mut before, mut beyond) = (0, 0);
        for points in 2..60 {
            for first in [1e-3, 1e-2, 0.1, 0.2] {
                let line = Line {
                    first,
                    ratio: libm::pow(1.0 / first, 1.0 / f64::from(points - 1)),
                };
                let stable = |i: &u32| family.at(line.point(*i)).is_hurwitz();
                let expected = (0..points).take_while(stable).count() as u32;
                assert_eq!(line.stable_points(&family, points), expected);
                before += u32::from((1..points).contains(&expected));
                beyond += u32::from(expected == points);
            }
        }
        assert!(before > 50 && beyond > 0, "{before}, {beyond}");
    }
}
