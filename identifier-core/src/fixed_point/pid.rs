use super::arithmetic::{Coefficient, FULL, Sum, Weight, Word, word};
use super::ranges::Scales;
use crate::identifier::IdentifierConfig;

/// The PID (3) on words, with command limit and anti-windup as [`Pid`](crate::control::Pid) has
/// them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedPid {
    proportional: Coefficient,
    derivative: Coefficient,
    integral: Coefficient,
    load: Coefficient,
    weight: Weight,
    /// Of the wanted command's full scale.
    low: Word,
    high: Word,
    /// From there to the command's full scale.
    up: u32,
}

/// A command and what anti-windup says of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedCommand {
    pub(super) value: Word,
    pub(super) integrates: bool,
}

impl FixedPid {
    pub(super) fn new(config: &IdentifierConfig, scales: &Scales) -> Self {
        let (units, gains) = (&config.units, &config.gains);
        let Scales {
            position,
            velocity,
            command,
            wanted,
            sum,
            ..
        } = *scales;
        let per_error = gains.ki() * units.rate() / units.position();
        // Where there is no limit the range is one: half of the command's full scale.
        let most = libm::ldexp(0.5, command);
        let limited = |limit: f64| word(limit.max(-most).min(most), wanted);
        Self {
            proportional: Coefficient::new(gains.kp() / units.position(), position, wanted),
            derivative: Coefficient::new(gains.kd() / units.velocity(), velocity, wanted),
            integral: Coefficient::new(per_error, sum, wanted),
            load: Coefficient::new(per_error, sum, command),
            weight: Weight::new(position, sum),
            low: limited(config.limit.low()),
            high: limited(config.limit.high()),
            up: (wanted - command).unsigned_abs(),
        }
    }

    /// u = kp e − kd v + ki ∑e, limited; `sum` as a word.
    #[inline]
    pub(super) fn command(&self, error: Word, velocity: Word, sum: Word) -> FixedCommand {
        // Each at most one half.
        let wanted = self.proportional.apply(error) - self.derivative.apply(velocity)
            + self.integral.apply(sum);
        let (limited, integrates) = if wanted > self.high {
            (self.high, error <= Word::ZERO)
        } else if wanted < self.low {
            (self.low, error >= Word::ZERO)
        } else {
            (wanted, true)
        };
        FixedCommand {
            value: limited << self.up,
            integrates,
        }
    }

    /// kd v, of the wanted command's full scale.
    #[inline]
    pub(super) fn damping(&self, velocity: Word) -> Word {
        self.derivative.apply(velocity)
    }

    /// Places from the wanted command's full scale up to the command's.
    #[inline]
    pub(super) fn up(&self) -> u32 {
        self.up
    }

    /// ki ∑, of the command's full scale; `sum` as a word.
    #[inline]
    pub(super) fn integral_command(&self, sum: Word) -> Word {
        self.load.apply(sum)
    }

    /// Adds an error to a sum, which stops at its full scale.
    #[inline]
    pub(super) fn gather(&self, sum: &mut Sum, error: Word) {
        let before = *sum;
        sum.add(error, self.weight);
        let word = sum.word();
        if word > FULL || word < -FULL {
            *sum = before;
        }
    }
}
