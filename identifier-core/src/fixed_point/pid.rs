use super::arithmetic::{Coefficient, Raise, Sum, Weight, Word, between, is_within, limit, word};
use super::ranges::FullScales;
use crate::constants::encode;
use crate::control::{CommandLimit, Gains};
use crate::units::Units;

/// The gains of a PID on words, and the sum that its integral is made of.
///
/// Proportional and derivative part have their own full scale, `wanted` (the command before the limit). Each is at most
/// half of it for any input.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PidTerms {
    proportional: Coefficient,
    derivative: Coefficient,
    weight: Weight,
    /// Integral part per unit of the summed error, machine units.
    per_error: f64,
    sum: i32,
    wanted: i32,
    /// From there to the command's full scale.
    up: Raise,
}

impl PidTerms {
    /// `rate` is the exponent of the derivative's input.
    fn new(units: &Units, gains: &Gains, scales: &FullScales, rate: i32) -> Self {
        let FullScales {
            position, command, ..
        } = *scales;
        let (kp, kd) = (gains.kp() / units.position(), gains.kd() / units.velocity());
        let wanted = Coefficient::least(kp, position)
            .max(Coefficient::least(kd, rate))
            .max(command);
        let sum = scales.sum(units, gains);
        Self {
            proportional: Coefficient::new(kp, position, wanted),
            derivative: Coefficient::new(kd, rate, wanted),
            weight: Weight::new(position, sum),
            per_error: FullScales::per_error(units, gains),
            sum,
            wanted,
            up: Raise::by(wanted - command),
        }
    }

    /// From the sum to a quantity of full scale 2^to: at most half of the command's.
    fn integral(&self, to: i32) -> Coefficient {
        Coefficient::new(self.per_error, self.sum, to)
    }
}

/// Adds an error to a sum, which stops at its full scale.
#[inline]
fn gather(sum: &mut Sum, error: Word, weight: Weight) {
    let mut next = *sum;
    next.add(error, weight);
    if is_within(next.word()) {
        *sum = next;
    }
}

/// The PID (3) on words, with command limit and anti-windup as [`Pid`](crate::control::Pid) has
/// them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedPid {
    proportional: Coefficient,
    derivative: Coefficient,
    integral: Coefficient,
    weight: Weight,
    /// Lowest command, of the full scale of the command before the limit.
    low: Word,
    high: Word,
    up: Raise,
}

encode! {
    [] FixedPid as "FixedPid" { proportional, derivative, integral, weight, low, high, up }
}

impl FixedPid {
    pub(super) fn new(
        units: &Units,
        gains: &Gains,
        limit: &CommandLimit,
        scales: &FullScales,
    ) -> Self {
        let terms = PidTerms::new(units, gains, scales, scales.velocity);
        // Where there is no limit the range is one.
        let most = scales.most_command();
        let limited = |limit: f64| word(limit.max(-most).min(most), terms.wanted);
        Self {
            proportional: terms.proportional,
            derivative: terms.derivative,
            integral: terms.integral(terms.wanted),
            weight: terms.weight,
            low: limited(limit.low()),
            high: limited(limit.high()),
            up: terms.up,
        }
    }

    /// u = k_p e − k_d v + k_i ∑e, limited, of the command's full scale. The error is then added to the sum. It is not
    /// added if the limit acts and the error would drive the command further beyond it.
    #[inline]
    pub(super) fn process(&self, sum: &mut Sum, error: Word, velocity: Word) -> Word {
        // Each at most one half.
        let wanted = self.proportional.apply(error) - self.derivative.apply(velocity)
            + self.integral.apply(sum.word());
        let (limited, integrates) = if wanted > self.high {
            (self.high, error <= Word::ZERO)
        } else if wanted < self.low {
            (self.low, error >= Word::ZERO)
        } else {
            (wanted, true)
        };
        if integrates {
            gather(sum, error, self.weight);
        }
        self.up.apply(limited)
    }
}

/// The correction in command form on words: [`CommandCorrection`](crate::model::CommandCorrection).
///
/// The part k_p ε + k_d ε̇ is limited to half of the command's full scale. The sum ω stops where k_i ω is as much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedCorrection {
    proportional: Coefficient,
    derivative: Coefficient,
    integral: Coefficient,
    weight: Weight,
    /// Half of the command's full scale, in that of the command before the limit.
    most: Word,
    up: Raise,
}

encode! {
    [] FixedCorrection as "FixedCorrection" {
        proportional, derivative, integral, weight, most, up,
    }
}

impl FixedCorrection {
    pub(super) fn new(units: &Units, gains: &Gains, scales: &FullScales) -> Self {
        let terms = PidTerms::new(units, gains, scales, scales.rate());
        Self {
            proportional: terms.proportional,
            derivative: terms.derivative,
            integral: terms.integral(scales.command),
            weight: terms.weight,
            most: word(scales.most_command(), terms.wanted),
            up: terms.up,
        }
    }

    /// u + k_p ε + k_d ε̇ + k_i ω, limited to the command's full scale. `command` is u, at most half of that scale, and
    /// `sum` is ω.
    #[inline]
    pub(super) fn process(
        &self,
        sum: &mut Sum,
        command: Word,
        output_error: Word,
        rate: Word,
    ) -> Word {
        let load = self.load_command(*sum);
        gather(sum, output_error, self.weight);
        let wanted = self.proportional.apply(output_error) + self.derivative.apply(rate);
        let feedback = self.up.apply(between(wanted, -self.most, self.most));
        limit(command + feedback + load)
    }

    /// k_i ω, the load over the gain, of the command's full scale: at most half of it.
    #[inline]
    pub(super) fn load_command(&self, sum: Sum) -> Word {
        self.integral.apply(sum.word())
    }
}
