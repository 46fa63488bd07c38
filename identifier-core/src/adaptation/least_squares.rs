use super::Covariance;
use crate::error::{Allowed, OutOfRange};
use crate::number::{Number, RunningSum};
use crate::units::Units;

/// Recursive least squares with forgetting factor on filtered input and output: the method that
/// the paper compares itself with.
///
/// Dividing (2) with d = 0 by Λ(s) = (s + λ)²/λ² leaves signals that are all to be had from
/// position and command: q̈_f = −a q̇_f + b u_f (Sastry and Bodson, Adaptive Control: Stability,
/// Convergence and Robustness, 1989, section 2.2). Both filters are the exact zero-order-hold step
/// of the same Λ over the sample just passed: the command was held, and a position taken as
/// straight between two samples has the held velocity Δq. The prediction error
/// q̈_f − θ̂ᵀ[−q̇_f, u_f] drives the usual recursion with forgetting factor (Nelles, Nonlinear
/// System Identification, 2001, section 3.2).
///
/// It has no term for a constant load: a load biases it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquares<N> {
    filter: StateVariableFilter<N>,
    noise: N,
    growth: N,
    initial: [f64; 2],
    variances: [f64; 2],
    units: Units,
}

/// The SI configuration of [`LeastSquares`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquaresConfig {
    /// Cut-off λ of the filter, rad/s: above the motion's frequencies, well below Nyquist.
    pub cutoff: f64,
    /// Forgetting factor, above 0 and at most 1. Its memory is T/(1 − factor) seconds.
    pub forgetting: f64,
    /// Initial [â, b̂].
    pub initial: [f64; 2],
    /// Standard deviations of the initial estimates, relative to unit noise of the filtered
    /// acceleration, 1 rad/s².
    pub uncertainty: [f64; 2],
}

/// What the recursion remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquaresState<N: Number> {
    position: N,
    command: N,
    motion: Filtered<N>,
    drive: Filtered<N>,
    estimates: [N::Sum; 2],
    covariance: Covariance<N, 2>,
}

impl<N: Number> LeastSquares<N> {
    /// The recursion from its configuration.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    pub fn new(units: &Units, config: &LeastSquaresConfig) -> Result<Self, OutOfRange> {
        Allowed::PositiveUpTo(1.0).check("forgetting", config.forgetting)?;
        for value in config.initial {
            Allowed::Finite.check("initial", value)?;
        }
        for value in config.uncertainty {
            Allowed::Above(0.0).check("uncertainty", value)?;
        }
        let scale = [units.rate(), units.acceleration()];
        let noise = units.acceleration() * units.acceleration();
        Ok(Self {
            filter: StateVariableFilter::new(units, config.cutoff)?,
            // The recursion weighs by ratios only: working with unit noise and regressors in units
            // of the noise keeps small numbers out of f32.
            noise: N::from_f64(config.forgetting * noise),
            growth: N::from_f64(1.0 / config.forgetting),
            initial: core::array::from_fn(|i| config.initial[i] * scale[i]),
            variances: core::array::from_fn(|i| {
                let deviation = config.uncertainty[i] * scale[i];
                deviation * deviation
            }),
            units: *units,
        })
    }

    /// The state at rest at a position (machine units).
    #[must_use]
    pub fn start(&self, position: N) -> LeastSquaresState<N> {
        LeastSquaresState {
            position,
            command: N::ZERO,
            motion: Filtered::AT_REST,
            drive: Filtered::AT_REST,
            estimates: self.initial.map(|value| N::Sum::new(N::from_f64(value))),
            covariance: Covariance::diagonal(self.variances),
        }
    }

    /// One sample: the measured position, and the command that is held from now on.
    #[inline]
    pub fn process(&self, state: &mut LeastSquaresState<N>, position: N, command: N) {
        let increment = position - state.position;
        if !(increment.is_finite() && command.is_finite()) {
            return;
        }
        self.filter.process(&mut state.motion, increment);
        self.filter.process(&mut state.drive, state.command);
        let regressor = [-state.motion.value, state.drive.value];
        let predicted =
            state.estimates[0].value() * regressor[0] + state.estimates[1].value() * regressor[1];
        let error = state.motion.rate - predicted;
        let innovation = state.covariance.measure(&regressor, |_| self.noise);
        state.covariance.inflate(self.growth);
        for (estimate, gain) in state.estimates.iter_mut().zip(innovation.gain) {
            estimate.add(gain * error);
        }
        state.position = position;
        state.command = command;
    }

    /// The estimates [â, b̂] in SI.
    #[must_use]
    pub fn estimates(&self, state: &LeastSquaresState<N>) -> [f64; 2] {
        let [x, gain] = state.estimates.map(|sum| sum.value().to_f64());
        [x / self.units.rate(), gain / self.units.acceleration()]
    }
}

/// λ²/(s + λ)², stepped exactly for a held input, with its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StateVariableFilter<N> {
    transition: [[N; 2]; 2],
    input: [N; 2],
}

/// A filtered signal and its rate, per sample.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Filtered<N> {
    value: N,
    rate: N,
}

impl<N: Number> Filtered<N> {
    const AT_REST: Self = Self {
        value: N::ZERO,
        rate: N::ZERO,
    };
}

impl<N: Number> StateVariableFilter<N> {
    fn new(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        let nyquist = core::f64::consts::PI / units.sample_time();
        let l = Allowed::Between(0.0, nyquist).check("cutoff", cutoff)? * units.rate();
        let decay = libm::exp(-l);
        let number = N::from_f64;
        Ok(Self {
            transition: [
                [number(decay * (1.0 + l)), number(decay)],
                [number(-decay * l * l), number(decay * (1.0 - l))],
            ],
            input: [number(1.0 - decay * (1.0 + l)), number(decay * l * l)],
        })
    }

    #[inline]
    fn process(&self, state: &mut Filtered<N>, input: N) {
        let [[vv, vr], [rv, rr]] = self.transition;
        let [iv, ir] = self.input;
        let Filtered { value, rate } = *state;
        state.value = vv * value + vr * rate + iv * input;
        state.rate = rv * value + rr * rate + ir * input;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filter_steps_like_the_continuous_one() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        let filter = StateVariableFilter::<f64>::new(&units, 80.0).expect("valid");
        let mut state = Filtered::AT_REST;
        for k in 1..=200 {
            filter.process(&mut state, 1.0);
            let lt = 80.0 * 1e-3 * f64::from(k);
            let value = 1.0 - libm::exp(-lt) * (1.0 + lt);
            let rate = 80.0 * 1e-3 * lt * libm::exp(-lt);
            assert!((state.value - value).abs() < 1e-12, "sample {k}");
            assert!((state.rate - rate).abs() < 1e-12, "sample {k}");
        }
    }
}
