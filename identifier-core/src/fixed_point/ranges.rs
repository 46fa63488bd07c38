use super::arithmetic::{WORD_BITS, exponent_above, power};
use crate::error::{Allowed, OutOfRange};
use crate::identifier::IdentifierConfig;
use crate::parameters::Parameter;

/// What the loop's signals stay within, SI: the full scales of the words. A signal beyond is
/// saturated there, never wrapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranges {
    /// Position error and output error, rad.
    pub error: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Command, command units.
    pub command: f64,
}

impl Ranges {
    /// Room above what the command limit lets the loop ask for.
    const ROOM: f64 = 4.0;

    /// Ranges that follow from the loop: four times the error and the velocity at which the PID alone
    /// would ask for the whole command. Without a limit the command is taken to be what an error of
    /// one turn asks for.
    #[must_use]
    pub fn of(config: &IdentifierConfig) -> Self {
        let (kp, kd) = (config.gains.kp(), config.gains.kd());
        let limit = config.limit.high().max(-config.limit.low());
        let command = if limit < kp * core::f64::consts::TAU {
            limit
        } else {
            kp * core::f64::consts::TAU
        };
        let damping = kd.max(libm::sqrt(kp / config.bounds.b.max()));
        Self {
            error: Self::ROOM * command / kp,
            velocity: Self::ROOM * command / damping,
            command: Self::ROOM * command,
        }
    }
}

/// The exponents of the full scales, machine units: a word w of a quantity stands for
/// w · 2^exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scales {
    pub(super) position: i32,
    pub(super) velocity: i32,
    pub(super) command: i32,
    pub(super) acceleration: i32,
    pub(super) rate: i32,
    pub(super) gain: i32,
    pub(super) coulomb: i32,
    pub(super) load: i32,
    /// Fraction bits below the velocity's full scale that the output error is kept with.
    pub(super) fine: i32,
}

impl Scales {
    /// Guard bits that the fine output error keeps above the position's full scale.
    const GUARD: i32 = 2;

    /// Bits that the position's full scale may be above the velocity's: the rest is fraction.
    const MOST_BETWEEN: i32 = 30;

    /// Bits below a count that a position error must keep.
    const BELOW_A_COUNT: i32 = 4;

    pub(super) fn new(config: &IdentifierConfig, ranges: &Ranges) -> Result<Self, OutOfRange> {
        let units = &config.units;
        for (name, range) in [
            ("ranges.error", ranges.error),
            ("ranges.velocity", ranges.velocity),
            ("ranges.command", ranges.command),
        ] {
            Allowed::Above(0.0).check(name, range)?;
        }
        let position = exponent_above(ranges.error * units.position());
        let most = power(WORD_BITS - Self::BELOW_A_COUNT) * units.position_unit();
        Allowed::AtMost(most).check("ranges.error", ranges.error)?;
        let velocity = exponent_above(ranges.velocity * units.velocity());
        let least = ranges.error * units.rate().recip() * power(-Self::MOST_BETWEEN);
        if position - velocity > Self::MOST_BETWEEN {
            Allowed::AtLeast(least).check("ranges.velocity", ranges.velocity)?;
        }
        let limit = config.limit.high().max(-config.limit.low());
        if limit.is_finite() {
            Allowed::AtLeast(limit).check("ranges.command", ranges.command)?;
        }
        let largest = |parameter: Parameter| {
            let bounds = config.bounds.of(parameter);
            libm::fabs(bounds.min()).max(libm::fabs(bounds.max())) * parameter.scale(units)
        };
        let exponent = |parameter| exponent_above(largest(parameter));
        let drive = largest(Parameter::B) * ranges.command;
        Ok(Self {
            position,
            velocity,
            command: exponent_above(ranges.command),
            acceleration: exponent_above(drive),
            rate: exponent(Parameter::A),
            gain: exponent(Parameter::B),
            coulomb: exponent(Parameter::Coulomb),
            load: exponent(Parameter::Load),
            fine: (62 - Self::GUARD - (position - velocity).max(0)).min(60),
        })
    }

    pub(super) fn of(&self, parameter: Parameter) -> i32 {
        match parameter {
            Parameter::A => self.rate,
            Parameter::B => self.gain,
            Parameter::Coulomb => self.coulomb,
            Parameter::Load => self.load,
        }
    }

    /// The exponent of what the regressor (9) has for a parameter.
    pub(super) fn regressor(&self, parameter: Parameter) -> i32 {
        match parameter {
            Parameter::A => self.velocity,
            Parameter::B => self.command,
            Parameter::Coulomb | Parameter::Load => 0,
        }
    }
}
