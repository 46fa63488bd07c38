use crate::control::Gains;
use crate::number::{Number, RunningSum};
use crate::units::Units;

/// The feedback on the output error ε that keeps the model close to the servo. It is the identifier's
/// own.
pub trait Correction<N: Number>: Copy + core::fmt::Debug {
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
pub struct Corrected<N> {
    /// Added to the command, so that b̂ multiplies it.
    pub command: N,
    /// Added to the acceleration.
    pub acceleration: N,
}

/// The command form, the paper's: u_ε = k_p ε + k_d ε̇ + k_i ω, ω = ∫ε.
///
/// It takes the place of the second PID (6): the same gains, velocity filter and sum (the samples
/// before this one), without limit and anti-windup, since the command that acted is limited already.
/// The integral also estimates the load, d̂ = b̂ k_i ω, by ω → 0 in (9). As b̂ multiplies the
/// correction, the sampled loop must be stable for every b̂ that the bounds allow
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
        }
    }

    #[inline]
    fn load_command(&self, (): &()) -> N {
        N::ZERO
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    /// The real part of (jω + μ)/(l_p − ω² + jαω), its sign.
    fn real_part(mu: f64, alpha: f64, lp: f64, omega: f64) -> f64 {
        let (re, im) = (lp - omega * omega, alpha * omega);
        (mu * re + omega * im) / (re * re + im * im)
    }

    /// The error loop ε̈ + α ε̇ + l_p ε = φᵀθ̃ under (11) with Γ = γ, in small steps: the largest rise of
    /// its Lyapunov function over where it began.
    fn rise(mu: f64, alpha: f64, lp: f64, gamma: f64, phi: impl Fn(f64) -> f64) -> f64 {
        const STEPS: u32 = 40_000;
        let dt = 2e-3 / (alpha + lp.sqrt() + gamma.sqrt());
        let (mut error, mut rate, mut theta) = (0.3, 0.0, 1.0);
        // ½ y² + ½ k ε² with k = l_p − (α − μ) μ: its derivative is y φθ̃ − (α − μ) y² − k μ ε².
        let k = lp - (alpha - mu) * mu;
        let storage = |error: f64, rate: f64, theta: f64| {
            let y = rate + mu * error;
            0.5 * (y * y + k * error * error + theta * theta / gamma)
        };
        let start = storage(error, rate, theta);
        let mut most = 0.0_f64;
        for step in 0..STEPS {
            let phi = phi(f64::from(step) * dt);
            // The midpoint of the step, so that the error of the integration is of third order.
            let slope = |error: f64, rate: f64, theta: f64| {
                let y = rate + mu * error;
                (
                    rate,
                    phi * theta - alpha * rate - lp * error,
                    -gamma * phi * y,
                )
            };
            let (e, r, t) = slope(error, rate, theta);
            let half = 0.5 * dt;
            let (e, r, t) = slope(error + half * e, rate + half * r, theta + half * t);
            error += dt * e;
            rate += dt * r;
            theta += dt * t;
            most = most.max(storage(error, rate, theta) / start - 1.0);
        }
        most
    }

    proptest! {
        #[test]
        fn it_is_passive_exactly_where_mu_is_at_most_alpha(
            alpha in 0.1_f64..1e4,
            lp in 0.1_f64..1e6,
            part in 0.01_f64..3.0,
        ) {
            let mu = part * alpha;
            let frequencies = (-60..=60).map(|k| lp.sqrt() * 10_f64.powf(f64::from(k) / 10.0));
            let passive = frequencies.clone().all(|omega| real_part(mu, alpha, lp, omega) >= 0.0);
            if mu <= alpha {
                prop_assert!(passive);
            } else if mu > 1.01 * alpha {
                prop_assert!(!passive, "at high frequencies the delay of {mu} shows");
            }
        }

        #[test]
        fn its_lyapunov_function_never_rises(
            alpha in 1.0_f64..100.0,
            part in 0.05_f64..1.0,
            above in 1.0_f64..4.0,
            gamma in 0.1_f64..1e4,
            frequency in 0.1_f64..10.0,
        ) {
            let mu = part * alpha;
            // So that the function above is one, k > 0; passivity itself asks for nothing.
            let lp = above * ((alpha - mu) * mu + 0.01 * alpha * alpha);
            let phi = |time: f64| {
                let turns = time * frequency * alpha;
                if (turns as u64).is_multiple_of(2) { 1.0 } else { -0.7 }
            };
            let rise = rise(mu, alpha, lp, gamma, phi);
            prop_assert!(rise < 1e-6, "mu {mu}, alpha {alpha}, lp {lp}: it rises by {rise:e}");
        }
    }
}
