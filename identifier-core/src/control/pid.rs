use super::{CommandLimit, Gains};
use crate::constants::encode;
use crate::number::{Arithmetic, Encoded, Number};
use crate::scales::{APART, FullScales, exponent_above, least};
use crate::units::Units;

/// The PID (3) in machine units, with command limit and anti-windup. u = k_p e − k_d v + k_i ∑e, limited.
///
/// The caller brings error, velocity and sum. Which velocity, which sum and when the sum stops is in the documentation
/// of the [module](super).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pid<N: Arithmetic> {
    terms: PidTerms<N>,
    /// 1/k_i, for a sample to divide by nothing; zero without integral action.
    per_integral: N,
    /// Lowest and highest command, in the full scale of the terms.
    low: N,
    high: N,
}

encode! {
    [N: Encoded] Pid<N> as "Pid" { terms, per_integral, low, high }
}

/// The gains of a PID, and the sum of errors that its integral is made of.
///
/// In fixed point proportional and derivative term have their own full scale. Each is at most half of it for any input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PidTerms<N: Arithmetic> {
    pub(crate) proportional: N::Factor,
    pub(crate) derivative: N::Factor,
    pub(crate) integral: N::Factor,
    /// From an error to the sum.
    pub(crate) to_sum: N::Shift,
    /// From the full scale of the terms to the command's.
    pub(crate) to_command: N::Shift,
}

encode! {
    [N: Encoded] PidTerms<N> as "PidTerms" { proportional, derivative, integral, to_sum, to_command }
}

/// The integral term per unit of the summed error, machine units.
pub(crate) fn per_error(units: &Units, gains: &Gains) -> f64 {
    gains.ki() * units.rate() / units.position()
}

/// The exponent of a sum of errors. It is the largest that demands at most half of the command's full scale.
pub(crate) fn sum_exponent(units: &Units, gains: &Gains, scales: &FullScales) -> i32 {
    let per_error = per_error(units, gains);
    if per_error > 0.0 {
        scales.command - 1 - exponent_above(per_error)
    } else {
        scales.position + APART.0
    }
}

impl<N: Arithmetic> PidTerms<N> {
    /// The terms, and the exponent of their full scale. `rate` is that of the derivative's input. The integral term has
    /// that full scale, or the command's.
    pub(crate) fn new(
        units: &Units,
        gains: &Gains,
        scales: &FullScales,
        rate: i32,
        integral_is_command: bool,
    ) -> (Self, i32) {
        let FullScales {
            position, command, ..
        } = *scales;
        let (kp, kd) = (gains.kp() / units.position(), gains.kd() / units.velocity());
        let wanted = least(kp, position).max(least(kd, rate)).max(command);
        let sum = sum_exponent(units, gains, scales);
        let to = if integral_is_command { command } else { wanted };
        let terms = Self {
            proportional: N::factor(kp, position, wanted),
            derivative: N::factor(kd, rate, wanted),
            integral: N::factor(per_error(units, gains), sum, to),
            to_sum: N::lower((sum - position).min(APART.1)),
            to_command: N::raise(wanted - command),
        };
        (terms, wanted)
    }
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
}

impl<N: Arithmetic> Pid<N> {
    /// The control law for SI gains and a command limit.
    pub(crate) fn new(
        units: &Units,
        gains: &Gains,
        limit: &CommandLimit,
        scales: &FullScales,
    ) -> Self {
        let (terms, wanted) = PidTerms::new(units, gains, scales, scales.velocity, false);
        let per_integral = N::signal(1.0 / per_error(units, gains), 0);
        // Where there is no limit the range is one.
        let most = if N::IS_FIXED {
            scales.most_command()
        } else {
            N::REACH.value(wanted)
        };
        let limited = |limit: f64| N::signal(limit.max(-most).min(most), wanted);
        Self {
            terms,
            per_integral: if per_integral.is_finite() {
                per_integral
            } else {
                N::ZERO
            },
            low: limited(limit.low()),
            high: limited(limit.high()),
        }
    }

    /// u = k_p e − k_d v + k_i ∑e, not limited; the sum is ∑e of the samples before this one.
    #[inline(always)]
    pub(crate) fn wanted(&self, error: N, velocity: N, sum: N::Sum) -> N {
        self.linear(error, velocity) + N::of_sum(sum).by(self.terms.integral)
    }

    /// True within the limits; false for NaN.
    #[inline(always)]
    pub(crate) fn is_within(&self, wanted: N) -> bool {
        wanted <= self.high && wanted >= self.low
    }

    /// A command that is not within the limits, at this error, limited. None for a command that is no number, or beyond
    /// the range of the number format.
    #[inline(always)]
    pub(crate) fn limited(&self, wanted: N, error: N) -> Option<Command<N>> {
        let is_high = wanted > self.high;
        let is_limited = N::IS_FIXED || self.high < N::REACH;
        let is_number = is_high || wanted < self.low;
        (is_limited && is_number).then_some(if is_high {
            Command {
                value: self.high,
                integrates: error <= N::ZERO,
            }
        } else {
            Command {
                value: self.low,
                integrates: error >= N::ZERO,
            }
        })
    }

    /// A command in its full scale.
    #[inline(always)]
    pub(crate) fn as_command(&self, wanted: N) -> N {
        wanted.raised(self.terms.to_command)
    }

    /// Adds an error to the sum.
    #[inline(always)]
    pub(crate) fn gather(&self, sum: &mut N::Sum, error: N) {
        N::gather(sum, error, self.terms.to_sum);
    }

    /// The proportional and derivative parts of a command, without limit: k_p e − k_d v.
    #[inline(always)]
    pub(crate) fn linear(&self, error: N, velocity: N) -> N {
        error.by(self.terms.proportional) - velocity.by(self.terms.derivative)
    }
}

impl<N: Number> Pid<N> {
    /// The control law for k_p, k_d and k_i in machine units, and the lowest and highest command. Here k_i is above
    /// zero.
    pub(crate) fn in_machine_units(
        [proportional, derivative, integral]: [N; 3],
        [low, high]: [N; 2],
    ) -> Self {
        Self {
            terms: PidTerms {
                proportional,
                derivative,
                integral,
                to_sum: (),
                to_command: (),
            },
            per_integral: integral.reciprocal(),
            low: low.larger(-N::REACH),
            high: high.smaller(N::REACH),
        }
    }

    /// The same with k_p, k_d and k_i multiplied by these factors, above zero.
    pub(crate) fn scaled(self, [proportional, derivative, integral]: [N; 3]) -> Self {
        let terms = PidTerms {
            proportional: proportional * self.terms.proportional,
            derivative: derivative * self.terms.derivative,
            integral: integral * self.terms.integral,
            ..self.terms
        };
        Self {
            terms,
            per_integral: self.per_integral * integral.reciprocal(),
            ..self
        }
    }

    /// The integral ∑e for a bumpless transfer from a command: (u − k_p e + k_d v)/k_i. Zero without integral action.
    /// For the sample in which the controller takes over.
    pub(crate) fn integral_for(&self, command: N, error: N, velocity: N) -> N {
        self.per_integral * (command - self.linear(error, velocity))
    }
}
