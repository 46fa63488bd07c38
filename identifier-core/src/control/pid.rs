use super::{CommandLimit, Gains};
use crate::constants::{Encode, encode};
use crate::number::Number;
use crate::units::Units;

/// The PID (3) in machine units, with command limit and anti-windup. u = k_p e − k_d v + k_i ∑e, limited.
///
/// It holds no state: the caller brings error, velocity and integral. Which velocity, which sum and when
/// the sum stops is in the documentation of the [module](super).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pid<N> {
    proportional: N,
    derivative: N,
    integral: N,
    /// 1/k_i, for a sample to divide by nothing; zero without integral action.
    per_integral: N,
    low: N,
    high: N,
}

encode! {
    [N: Encode] Pid<N> as "Pid" { proportional, derivative, integral, per_integral, low, high }
}

/// A command and the state of the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Command<N> {
    /// The limited command.
    pub value: N,
    /// False if the limit acts and the error would drive the command further beyond it. The error must then not be
    /// added to the integral. This is conditional integration (Åström and Hägglund, PID Controllers: Theory, Design and
    /// Tuning, 2nd ed., 1994, section 3.5).
    pub integrates: bool,
    /// True if the limit changed the command.
    pub limited: bool,
}

impl<N: Number> Pid<N> {
    /// The control law for SI gains and a command limit.
    #[must_use]
    pub(crate) fn new(units: &Units, gains: &Gains, limit: &CommandLimit) -> Self {
        let integral = gains.ki() * units.rate() / units.position();
        let per_integral = N::from_f64(1.0 / integral);
        Self {
            proportional: N::from_f64(gains.kp() / units.position()),
            derivative: N::from_f64(gains.kd() / units.velocity()),
            integral: N::from_f64(integral),
            per_integral: if per_integral.is_finite() {
                per_integral
            } else {
                N::ZERO
            },
            low: N::from_f64(limit.low()),
            high: N::from_f64(limit.high()),
        }
    }

    /// The control law for k_p, k_d and k_i in machine units, and the lowest and highest command. Here k_i is above
    /// zero.
    pub(crate) fn in_machine_units(
        [proportional, derivative, integral]: [N; 3],
        [low, high]: [N; 2],
    ) -> Self {
        Self {
            proportional,
            derivative,
            integral,
            per_integral: integral.reciprocal(),
            low,
            high,
        }
    }

    /// The same with k_p, k_d and k_i multiplied by these factors, above zero.
    pub(crate) fn scaled(self, [proportional, derivative, integral]: [N; 3]) -> Self {
        Self {
            proportional: proportional * self.proportional,
            derivative: derivative * self.derivative,
            integral: integral * self.integral,
            per_integral: self.per_integral * integral.reciprocal(),
            ..self
        }
    }

    /// u = k_p e − k_d v + k_i ∑e; the integral is ∑e of the samples before this one.
    #[inline]
    pub(crate) fn wanted(&self, error: N, velocity: N, integral: N) -> N {
        self.linear(error, velocity) + self.integral * integral
    }

    /// A command that is wanted, at this error, limited.
    #[inline]
    pub(crate) fn limited(&self, wanted: N, error: N) -> Command<N> {
        if wanted > self.high {
            Command {
                value: self.high,
                integrates: error <= N::ZERO,
                limited: true,
            }
        } else if wanted < self.low {
            Command {
                value: self.low,
                integrates: error >= N::ZERO,
                limited: true,
            }
        } else {
            Command {
                value: wanted,
                integrates: true,
                limited: false,
            }
        }
    }

    /// The integral ∑e for a bumpless transfer from a command: (u − k_p e + k_d v)/k_i. Zero without integral action.
    /// For the sample in which the controller takes over.
    pub(crate) fn integral_for(&self, command: N, error: N, velocity: N) -> N {
        self.per_integral * (command - self.linear(error, velocity))
    }

    /// The proportional and derivative parts of a command, without limit: k_p e − k_d v.
    #[inline]
    pub(crate) fn linear(&self, error: N, velocity: N) -> N {
        self.proportional * error - self.derivative * velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Pid<f64> {
        fn command(&self, error: f64, velocity: f64, integral: f64) -> Command<f64> {
            self.limited(self.wanted(error, velocity, integral), error)
        }
    }

    fn pid(limit: CommandLimit) -> Pid<f64> {
        let units = Units::new(1e-3, 0.5).expect("valid");
        let gains = Gains::new(9.0, 0.19, 4.0).expect("valid");
        Pid::new(&units, &gains, &limit)
    }

    #[test]
    fn computes_the_law_in_si() {
        // e = 0.1 rad, q̇ = 2 rad/s, ∫e = 0.05 rad s, in units of 0.5 rad and 1 ms.
        let command = pid(CommandLimit::NONE).command(0.2, 2.0 * 1e-3 / 0.5, 0.05 / (0.5 * 1e-3));
        assert!((command.value - (9.0 * 0.1 - 0.19 * 2.0 + 4.0 * 0.05)).abs() < 1e-12);
        assert!(command.integrates);
    }

    #[test]
    fn limit_holds_and_the_integral_waits_only_where_it_would_wind_up() {
        let limited = pid(CommandLimit::asymmetric(-0.5, 2.0).expect("valid"));
        let up = limited.command(1.0, 0.0, 0.0);
        assert_eq!((up.value, up.integrates), (2.0, false));
        let down = limited.command(-1.0, 0.0, 0.0);
        assert_eq!((down.value, down.integrates), (-0.5, false));
        let unwinding = limited.command(-0.1, 0.0, 5000.0);
        assert_eq!((unwinding.value, unwinding.integrates), (2.0, true));
    }
}
