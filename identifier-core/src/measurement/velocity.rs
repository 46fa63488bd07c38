//! Velocity estimates from sampled positions.
//!
//! Each estimate is a linear filter over the *increments* of position. So neither the estimate nor its precision
//! depends on the position or the distance travelled. The same filter must act on the servo's position, on the model's
//! and on the regressor. As it is linear, the difference of two velocity estimates is the estimate of the difference.
//! So one state is enough.

use crate::constants::{Encode, encode};
use crate::error::{Allowed, OutOfRange};
use crate::number::{Arithmetic, Encoded, Number};
use crate::units::Units;

/// A velocity estimate: position increments in, velocity (machine units, per sample) out.
///
/// It has unit gain, so that it serves signals of any full scale.
pub trait VelocityEstimate<N>: Copy + core::fmt::Debug {
    /// The filter's memory between samples.
    type State: Copy + core::fmt::Debug + Default + PartialEq;

    /// The estimate with a cut-off in rad/s; an estimate without one ignores it.
    ///
    /// # Errors
    /// `cutoff` out of range.
    fn with_cutoff(units: &Units, cutoff: f64) -> Result<Self, OutOfRange>;

    /// The velocity after the position has moved by `increment` since the last sample.
    fn process(&self, state: &mut Self::State, increment: N) -> N;

    /// The filter's transfer function from increment to velocity.
    fn transfer(&self) -> Transfer;
}

/// A pulse transfer function (n₁ z + n₀) / (z − p): enough for every estimate here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transfer {
    /// Numerator coefficients, lowest power of z first.
    pub numerator: [f64; 2],
    /// The pole p.
    pub pole: f64,
}

impl Transfer {
    /// The delay of a velocity that changes slowly, samples, behind the increments.
    pub(crate) fn lag(&self) -> f64 {
        let [before, now] = self.numerator;
        1.0 / (1.0 - self.pole) - now / (now + before)
    }
}

/// Low-pass derivative ω s/(s + ω), its pole mapped exactly: p = e^(−ωT).
///
/// v ← p v + (1 − p) Δq. A ramp is followed without error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass<N: Arithmetic> {
    pole: N,
    gain: N::Factor,
}

encode! {
    [N: Encoded] LowPass<N> as "LowPass" { pole, gain }
}

/// The largest cut-off over the sample rate in fixed point, whose factors are below one half: a little below ln 2.
const LARGEST_FIXED_CUTOFF: f64 = 0.693;

impl<N: Arithmetic> LowPass<N> {
    /// A low-pass derivative with a cut-off in rad/s.
    ///
    /// # Errors
    /// `cutoff` must be positive and below the Nyquist frequency π/T; in fixed point at most 0.693/T.
    pub fn new(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        let sample_time = units.sample_time();
        let allowed = if N::IS_FIXED {
            Allowed::PositiveUpTo(LARGEST_FIXED_CUTOFF / sample_time)
        } else {
            Allowed::Between(0.0, core::f64::consts::PI / sample_time)
        };
        allowed.check("cutoff", cutoff)?;
        let decay = -libm::expm1(-cutoff * units.rate());
        Ok(Self {
            pole: N::signal(1.0 - decay, 0),
            gain: N::factor(decay, 0, 0),
        })
    }
}

impl<N: Number> LowPass<N> {
    /// A low-pass that shows this part of a velocity step after one sample: 1 − p, from 0 to 1.
    #[must_use]
    pub fn passing(gain: N) -> Self {
        Self {
            pole: N::ONE - gain,
            gain,
        }
    }

    /// The part of a step of the velocity that it shows after a sample, 1 − p.
    #[must_use]
    pub fn passed(&self) -> N {
        self.gain
    }
}

/// The state of a [`LowPass`] estimate: the velocity, per sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPassState<N: Arithmetic>(N::Fine);

impl<N: Arithmetic> LowPassState<N> {
    /// The state of a servo that moves with a velocity, machine units.
    #[must_use]
    pub fn moving(velocity: N) -> Self {
        Self(velocity.fine())
    }
}

impl<N: Arithmetic> Default for LowPassState<N> {
    fn default() -> Self {
        Self::moving(N::ZERO)
    }
}

impl<N: Arithmetic> VelocityEstimate<N> for LowPass<N> {
    type State = LowPassState<N>;

    fn with_cutoff(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        Self::new(units, cutoff)
    }

    #[inline(always)]
    fn process(&self, state: &mut Self::State, increment: N) -> N {
        N::low_pass(&mut state.0, self.pole, self.gain, increment)
    }

    fn transfer(&self) -> Transfer {
        Transfer {
            numerator: [0.0, N::ONE.by(self.gain).value(0)],
            pole: self.pole.value(0),
        }
    }
}

/// Backward difference: v = Δq.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BackwardDifference;

encode! {
    [] BackwardDifference as "BackwardDifference" {}
}

impl<N: Arithmetic> VelocityEstimate<N> for BackwardDifference {
    type State = ();

    fn with_cutoff(_: &Units, _: f64) -> Result<Self, OutOfRange> {
        Ok(Self)
    }

    #[inline(always)]
    fn process(&self, _: &mut Self::State, increment: N) -> N {
        increment
    }

    fn transfer(&self) -> Transfer {
        Transfer {
            numerator: [0.0, 1.0],
            pole: 0.0,
        }
    }
}

/// Averaged difference: the backward difference of the mean of two successive positions,
/// v = (Δq + Δq⁻)/2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AveragedDifference<N> {
    half: N,
}

encode! {
    [N: Encode] AveragedDifference<N> as "AveragedDifference" { half }
}

impl<N: Arithmetic> AveragedDifference<N> {
    /// The estimate; it has no parameter.
    #[must_use]
    pub fn new() -> Self {
        Self {
            half: N::signal(0.5, 0),
        }
    }
}

impl<N: Arithmetic> Default for AveragedDifference<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// The state of an [`AveragedDifference`]: the last increment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AveragedDifferenceState<N>(N);

impl<N: Arithmetic> Default for AveragedDifferenceState<N> {
    fn default() -> Self {
        Self(N::ZERO)
    }
}

impl<N: Arithmetic> VelocityEstimate<N> for AveragedDifference<N> {
    type State = AveragedDifferenceState<N>;

    fn with_cutoff(_: &Units, _: f64) -> Result<Self, OutOfRange> {
        Ok(Self::new())
    }

    #[inline(always)]
    fn process(&self, state: &mut Self::State, increment: N) -> N {
        let velocity = (increment + state.0).part(self.half);
        state.0 = increment;
        velocity
    }

    fn transfer(&self) -> Transfer {
        Transfer {
            numerator: [0.5, 0.5],
            pole: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn units() -> Units {
        Units::new(1e-3, 1.0).expect("valid")
    }

    /// Settled response to a ramp must be its slope, and that of its transfer function.
    fn ramp_response<V: VelocityEstimate<f64>>(estimate: V) -> f64 {
        let Transfer { numerator, pole } = estimate.transfer();
        let gain = numerator.iter().sum::<f64>() / (1.0 - pole);
        assert!((gain - 1.0).abs() < 1e-12, "{gain}");
        let mut state = V::State::default();
        let velocities = (0..1000).map(|_| estimate.process(&mut state, 0.25));
        velocities.last().expect("samples")
    }

    #[test]
    fn every_estimate_follows_a_ramp_without_error() {
        let low_pass = LowPass::new(&units(), 500.0).expect("valid");
        assert!((ramp_response(low_pass) - 0.25).abs() < 1e-12);
        assert!((ramp_response(BackwardDifference) - 0.25).abs() < 1e-12);
        assert!((ramp_response(AveragedDifference::new()) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn low_pass_steps_like_the_continuous_filter() {
        let low_pass = LowPass::<f64>::new(&units(), 500.0).expect("valid");
        let mut state = Default::default();
        for k in 1..=20 {
            let velocity = low_pass.process(&mut state, 1.0);
            let continuous = 1.0 - (-500.0 * 1e-3 * f64::from(k)).exp();
            assert!((velocity - continuous).abs() < 1e-12, "sample {k}");
        }
    }

    #[test]
    fn cutoff_above_nyquist_is_refused_by_name() {
        let error = LowPass::<f64>::new(&units(), 3200.0).expect_err("above π/T");
        assert_eq!(error.parameter, "cutoff");
        assert!(LowPass::<f64>::new(&units(), 3100.0).is_ok());
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(LowPass::<f64>::new(&units(), bad).is_err(), "{bad}");
        }
    }
}
