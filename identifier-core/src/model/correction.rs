use crate::constants::{Encode, encode};
use crate::control::Gains;
use crate::number::{Number, RunningSum};
use crate::units::Units;

/// The feedback on the output error ε that keeps the model close to the servo. It is the identifier's
/// own.
pub(crate) trait Correction<N: Number>: Copy + core::fmt::Debug {
    /// Its state between samples.
    type State: Copy + core::fmt::Debug + PartialEq;

    /// An empty integral.
    fn start(&self) -> Self::State;

    /// The correction for an output error and its rate, machine units.
    fn process(&self, state: &mut Self::State, output_error: N, rate: N) -> Corrected<N>;

    /// k_i ω: the load over the gain as the correction's integral estimates it, command units; zero
    /// without an integral.
    fn load_command(&self, state: &Self::State) -> N;
}

/// A correction, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corrected<N> {
    /// Added to the command, so that b̂ multiplies it.
    pub command: N,
    /// Added to the acceleration.
    pub acceleration: N,
}

/// The command form, the paper's: u_ε = k_p ε + k_d ε̇ + k_i ω, ω = ∫ε.
///
/// It replaces the second PID (6). Gains, velocity filter and sum (the samples before this one) are the same. There is
/// no limit and no anti-windup, since the command that acted is limited already. The integral also estimates the load,
/// d̂ = b̂ k_i ω, by ω → 0 in (9). As b̂ multiplies the correction, the sampled loop must be stable for every b̂ that
/// the bounds allow ([`SampledLoop::check_estimates`](crate::stability::SampledLoop::check_estimates)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CommandCorrection<N> {
    proportional: N,
    derivative: N,
    integral: N,
}

encode! {
    [N: Encode] CommandCorrection<N> as "CommandCorrection" { proportional, derivative, integral }
}

impl<N: Number> CommandCorrection<N> {
    /// The correction with the gains of a PID: the user's own gives the paper's loop.
    #[must_use]
    pub(crate) fn new(units: &Units, gains: &Gains) -> Self {
        Self {
            proportional: N::from_f64(gains.kp() / units.position()),
            derivative: N::from_f64(gains.kd() / units.velocity()),
            integral: N::from_f64(gains.ki() * units.rate() / units.position()),
        }
    }
}

/// The integral ω = ∑ε of a [`CommandCorrection`], machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct IntegralError<S>(S);

impl<N: Number> Correction<N> for CommandCorrection<N> {
    type State = IntegralError<N::Sum>;

    fn start(&self) -> Self::State {
        IntegralError(N::Sum::new(N::ZERO))
    }

    #[inline]
    fn process(&self, state: &mut Self::State, output_error: N, rate: N) -> Corrected<N> {
        // As in the PID (3): the sum of the samples before this one.
        let load = self.load_command(state);
        state.0.add(output_error);
        Corrected {
            command: self.proportional * output_error + self.derivative * rate + load,
            acceleration: N::ZERO,
        }
    }

    #[inline]
    fn load_command(&self, state: &Self::State) -> N {
        self.integral * state.0.value()
    }
}
