use crate::control::Gains;
use crate::number::{Number, RunningSum};
use crate::units::Units;

/// What pulls the model to the servo: a feedback on the output error ε that is the identifier's own.
pub trait Correction<N: Number>: Copy + core::fmt::Debug {
    /// What it remembers between samples.
    type State: Copy + core::fmt::Debug + PartialEq;

    /// Nothing gathered.
    fn start(&self) -> Self::State;

    /// The correction for an output error and its rate, machine units.
    fn process(&self, state: &mut Self::State, output_error: N, rate: N) -> Corrected<N>;
}

/// A correction, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corrected<N> {
    /// Added to the command, so that b̂ multiplies it.
    pub command: N,
    /// Added to the acceleration.
    pub acceleration: N,
    /// The part of the command that an integral accounts for, k_i ω: the load over the gain.
    pub load: N,
}

/// The command form, the paper's: u_ε = k_p ε + k_d ε̇ + k_i ω, ω = ∫ε.
///
/// The integral finds the load for nothing, d̂ = b̂ k_i ω. As b̂ multiplies the correction, the sampled
/// loop must be stable for every b̂ that the bounds allow
/// ([`sampled_loop::check_estimates`](crate::stability::sampled_loop::check_estimates)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandCorrection<N> {
    proportional: N,
    derivative: N,
    integral: N,
}

impl<N: Number> CommandCorrection<N> {
    /// The correction with the gains of a PID: the user's own gives the paper's loop.
    #[must_use]
    pub fn new(units: &Units, gains: &Gains) -> Self {
        Self {
            proportional: N::from_f64(gains.kp() / units.position()),
            derivative: N::from_f64(gains.kd() / units.velocity()),
            integral: N::from_f64(gains.ki() * units.rate() / units.position()),
        }
    }
}

/// The integral ω = ∑ε of a [`CommandCorrection`], machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegralError<S>(S);

impl<N: Number> Correction<N> for CommandCorrection<N> {
    type State = IntegralError<N::Sum>;

    fn start(&self) -> Self::State {
        IntegralError(N::Sum::new(N::ZERO))
    }

    #[inline]
    fn process(&self, state: &mut Self::State, output_error: N, rate: N) -> Corrected<N> {
        // As in the PID (3): the sum of the samples before this one.
        let load = self.integral * state.0.value();
        state.0.add(output_error);
        Corrected {
            command: self.proportional * output_error + self.derivative * rate + load,
            acceleration: N::ZERO,
            load,
        }
    }
}

/// The acceleration form: l_p ε + l_d ε̇ added to the acceleration.
///
/// The error loop ε̈ + (a + l_d) ε̇ + l_p ε = φᵀθ̃ contains neither b nor b̂: no estimate can make it
/// unstable, and no box of b is needed. The load is a parameter of its own.
///
/// **Passivity.** From φᵀθ̃ to y = μ ε + ε̇ the loop is (s + μ)/(s² + α s + l_p) with α = a + l_d. On
/// s = jω the real part of (jω + μ)(l_p − ω² − jαω) is μ l_p + (α − μ) ω²: positive for every ω
/// exactly when **0 < μ ≤ α**. That is all; (14) asks for two conditions because of its integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccelerationCorrection<N> {
    proportional: N,
    derivative: N,
}

impl<N: Number> AccelerationCorrection<N> {
    /// Both poles of the error loop at −`bandwidth` (rad/s): l_p = ω², l_d = 2ω.
    #[must_use]
    pub fn new(units: &Units, bandwidth: f64) -> Self {
        let rate = bandwidth * units.rate();
        Self {
            proportional: N::from_f64(rate * rate),
            derivative: N::from_f64(2.0 * rate),
        }
    }
}

impl<N: Number> Correction<N> for AccelerationCorrection<N> {
    type State = ();

    fn start(&self) {}

    #[inline]
    fn process(&self, (): &mut (), output_error: N, rate: N) -> Corrected<N> {
        Corrected {
            command: N::ZERO,
            acceleration: self.proportional * output_error + self.derivative * rate,
            load: N::ZERO,
        }
    }
}
