use super::arithmetic::{Coefficient, WORD_BITS, Weight, exponent_above, power};
use crate::error::{Allowed, OutOfRange};
use crate::identifier::IdentifierConfig;
use crate::parameters::Parameter;

/// What the loop's signals stay within, SI: the full scales of the words are no smaller. A signal
/// beyond is saturated there, never wrapped.
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
///
/// They are chosen so that everything that is added up stays below one, and every product needs a
/// shift in one direction only: see the table of the module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scales {
    /// Position error and output error.
    pub(super) position: i32,
    /// Velocities, increments and, per sample, accelerations.
    pub(super) velocity: i32,
    /// Commands as they act on the model.
    pub(super) command: i32,
    /// Commands as the PID asks for them, before the limit.
    pub(super) wanted: i32,
    /// Sums of errors.
    pub(super) sum: i32,
    /// y = μ ε + ε̇.
    pub(super) output: i32,
}

/// The exponent of â T: its words are fractions of a quarter.
const RATE: i32 = -2;

impl Scales {
    /// Rounds in which the full scales come to agree.
    const ROUNDS: usize = 4;

    /// Bits below a count that a position error must keep.
    const BELOW_A_COUNT: i32 = 4;

    pub(super) fn new(config: &IdentifierConfig, ranges: &Ranges) -> Result<Self, OutOfRange> {
        let (units, gains) = (&config.units, &config.gains);
        for (name, range) in [
            ("ranges.error", ranges.error),
            ("ranges.velocity", ranges.velocity),
            ("ranges.command", ranges.command),
        ] {
            Allowed::Above(0.0).check(name, range)?;
        }
        let limit = config.limit.high().max(-config.limit.low());
        if limit.is_finite() {
            Allowed::AtLeast(limit).check("ranges.command", ranges.command)?;
        }
        let largest = |parameter: Parameter| {
            let bounds = config.bounds.of(parameter);
            libm::fabs(bounds.min()).max(libm::fabs(bounds.max())) * parameter.scale(units)
        };
        Allowed::AtMost(power(RATE) / units.rate())
            .check("bounds.a", largest(Parameter::A) / units.rate())?;
        let (least_apart, most_apart) = Weight::APART;
        let per_error = gains.ki() * units.rate() / units.position();
        let given = exponent_above(ranges.error * units.position());
        // Half for the limited command, half for the load beside it.
        let mut command = exponent_above(ranges.command);
        if limit.is_finite() {
            command = command.max(exponent_above(limit) + 1);
        }
        let (mut velocity, mut position) = (1, given);
        // Each full scale asks for room in the next: they agree at once, unless an error of one sample
        // asks for more than the whole command.
        for _ in 0..Self::ROUNDS {
            if per_error > 0.0 {
                command = command.max(exponent_above(per_error) + position + least_apart + 1);
            }
            velocity = [
                exponent_above(ranges.velocity * units.velocity()),
                // b u at most one half; friction and load a quarter.
                exponent_above(largest(Parameter::B)) + command + 1,
                exponent_above(largest(Parameter::Coulomb)) + 2,
                exponent_above(largest(Parameter::Load)) + 2,
            ]
            .into_iter()
            // At least a count a sample.
            .fold(1, i32::max);
            position = given.max(velocity + least_apart);
        }
        let most = power(WORD_BITS - Self::BELOW_A_COUNT) * units.position_unit();
        let needed = ranges
            .error
            .max(power(position - 1) * units.position_unit());
        Allowed::AtMost(most).check("ranges.error", needed)?;
        if position - velocity > most_apart {
            let least = ranges.error / units.rate() * power(-most_apart);
            Allowed::AtLeast(least).check("ranges.velocity", ranges.velocity)?;
        }
        // The largest sum of errors that asks for no more than half of the command's full scale.
        let sum = if per_error > 0.0 {
            command - 1 - exponent_above(per_error)
        } else {
            position + least_apart
        };
        if sum > position + most_apart {
            let least = power(command - 1 - position - most_apart) * units.position() / gains.ki();
            Allowed::AtLeast(least).check("sample_time", units.sample_time())?;
        }
        let wanted = Coefficient::least(gains.kp() / units.position(), position)
            .max(Coefficient::least(gains.kd() / units.velocity(), velocity))
            .max(command);
        Ok(Self {
            position,
            velocity,
            command,
            wanted,
            sum,
            output: velocity + 1,
        })
    }

    /// With the output's scale large enough for μ (machine units).
    pub(super) fn with_mu(self, mu: f64) -> Self {
        Self {
            output: self.output.max(Coefficient::least(mu, self.position)),
            ..self
        }
    }

    pub(super) fn of(&self, parameter: Parameter) -> i32 {
        match parameter {
            Parameter::A => RATE,
            Parameter::B => self.velocity - self.command,
            Parameter::Coulomb | Parameter::Load => self.velocity,
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
