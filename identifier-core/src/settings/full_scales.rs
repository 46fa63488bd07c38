use super::parameter_range::{SMALLEST_GAIN, allowed, parameter_range};
use super::{RangeSettings, Settings, SettingsError};
use crate::control::{Gains, per_error, sum_exponent};
use crate::error::{Allowed, OutOfRange};
use crate::number::Arithmetic;
use crate::parameters::{Parameter, ParameterSet};
use crate::scales::{APART, FullScales, exponent_above, power};
use crate::units::Units;

/// The exponents of the full scales.
///
/// # Errors
/// In fixed point a range, bound or sample time that does not fit, with the value that would.
pub(super) fn full_scales<N: Arithmetic>(settings: &Settings) -> Result<FullScales, SettingsError> {
    if N::IS_FIXED {
        FullScales::from_settings(settings)
    } else {
        Ok(FullScales::NONE)
    }
}

impl RangeSettings {
    /// Margin of the ranges over those that follow from the command limit.
    const ROOM: f64 = 4.0;

    /// The ranges of fixed point: those stated, or those that follow from the controller. The command range is then
    /// four times the limit. Error and velocity ranges are those at which the PID alone would command the limit. The
    /// command is taken to be at most that of an error of one turn.
    ///
    /// # Errors
    /// [`SettingsError::NotGiven`] if there is no controller, or if it has no damping and b has no bound. Also a gain
    /// or a limit out of its range.
    pub fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        const NOT_GIVEN: SettingsError = SettingsError::NotGiven { setting: "ranges" };
        if let Some(given) = settings.identifier.ranges {
            return Ok(given);
        }
        let gains = settings.controller.ok_or(NOT_GIVEN)?.gains()?;
        let kp = gains.kp();
        let of_a_turn = kp * core::f64::consts::TAU;
        let limit = settings.largest_command();
        let command = limit.unwrap_or(of_a_turn).min(of_a_turn);
        let of_position = match bounds(settings, Parameter::B)? {
            Some([_, most]) if most > 0.0 => libm::sqrt(kp / most),
            _ => 0.0,
        };
        let damping = gains.kd().max(of_position);
        if damping <= 0.0 {
            return Err(NOT_GIVEN);
        }
        // The output error is what the correction asks for the command with.
        let softest = settings.correction_gains()?.kp().min(kp);
        Ok(Self {
            error: Self::ROOM * command / softest,
            velocity: Self::ROOM * command / damping,
            // Never below a limit that even an error of a turn does not reach.
            command: (Self::ROOM * command).max(limit.unwrap_or(0.0)),
        })
    }
}

/// The factor by which an estimate b̂ may exceed the parameter range if no bound is given.
const BEYOND_THE_RANGE: f64 = 4.0;

/// Bounds of an estimate in fixed point: those given, or a known value. For b they may also follow from the parameter
/// range.
pub(super) fn bounds(
    settings: &Settings,
    parameter: Parameter,
) -> Result<Option<[f64; 2]>, SettingsError> {
    let given = &settings.identifier;
    if let Some(bounds) = given.bounds.get(parameter) {
        return Ok(Some(bounds));
    }
    if given.known.get(parameter) {
        let value = given.initial.get(parameter).unwrap_or(0.0);
        return Ok(Some([value, value]));
    }
    Ok(match (parameter, parameter_range(settings)?) {
        (Parameter::B, Some(given)) => {
            let b = given.b();
            Some([SMALLEST_GAIN.min(b.min()), BEYOND_THE_RANGE * b.max()])
        }
        _ => None,
    })
}

/// The largest |â|, 1/s.
fn largest_rate(units: &Units) -> f64 {
    power(FullScales::RATE) / units.rate()
}

/// The settings with every bound that fixed point needs for a parameter set.
pub(super) fn bounded<S: ParameterSet<P>, const P: usize>(
    settings: &Settings,
) -> Result<Settings, SettingsError> {
    let largest = largest_rate(&settings.units()?);
    let mut filled = *settings;
    for parameter in S::PARAMETERS {
        let found = bounds(settings, parameter)?;
        let not_given = |setting| SettingsError::NotGiven { setting };
        let all = &mut filled.identifier.bounds;
        match parameter {
            Parameter::A => {
                let found = found.unwrap_or([0.0, largest]);
                for bound in found {
                    Allowed::Within(-largest, largest).check("bounds.a", bound)?;
                }
                all.a = Some(found);
            }
            // If it follows from the parameter range, the sampled correction may need less.
            Parameter::B => {
                found.ok_or(not_given("bounds.b"))?;
                if settings.identifier.known.b {
                    all.b = found;
                }
            }
            Parameter::Coulomb => all.coulomb = Some(found.ok_or(not_given("bounds.coulomb"))?),
            Parameter::Load => all.load = Some(found.ok_or(not_given("bounds.load"))?),
        }
    }
    Ok(filled)
}

impl FullScales {
    /// Fraction bits of a word.
    const WORD_BITS: i32 = 30;

    /// Rounds in which the full scales come to agree.
    const ROUNDS: usize = 4;

    /// Bits below a count that a position error must keep.
    const BELOW_A_COUNT: i32 = 4;

    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let units = settings.units()?;
        let ranges = RangeSettings::from_settings(settings)?;
        let limit = settings.largest_command();
        let own = match settings.controller {
            Some(controller) => Some(controller.gains()?),
            None => None,
        };
        let correction = match settings.correction_gains() {
            Ok(gains) => Some(gains),
            // A controller needs none.
            Err(SettingsError::NotGiven { .. }) => None,
            Err(error) => return Err(error),
        };
        let largest = |parameter: Parameter| {
            let given = bounds(settings, parameter)?;
            let [low, high] = given.unwrap_or([0.0; 2]);
            let largest = libm::fabs(low).max(libm::fabs(high));
            let (_, name, _) = allowed(parameter, &units);
            Allowed::Finite.check(name, largest)?;
            Ok::<_, SettingsError>(exponent_above(largest * parameter.scale(&units)))
        };
        let accelerations = [
            largest(Parameter::B)?,
            largest(Parameter::Coulomb)?,
            largest(Parameter::Load)?,
        ];
        // A count more, so that a larger increment never saturates to an allowed one.
        let fastest = match settings.identifier.max_speed {
            Some(speed) => Allowed::Above(0.0).check("max_speed", speed)? * units.velocity() + 1.0,
            None => 0.0,
        };
        let gains = [own, correction];
        let gains = gains.iter().flatten();
        Ok(Self::new(
            &units,
            &ranges,
            limit,
            gains,
            fastest,
            accelerations,
        )?)
    }

    /// `accelerations` are the exponents of b, Coulomb friction and load.
    fn new<'a>(
        units: &Units,
        ranges: &RangeSettings,
        limit: Option<f64>,
        gains: impl Iterator<Item = &'a Gains> + Clone,
        fastest: f64,
        [b, coulomb, load]: [i32; 3],
    ) -> Result<Self, OutOfRange> {
        for (name, range) in [
            ("ranges.error", ranges.error),
            ("ranges.velocity", ranges.velocity),
            ("ranges.command", ranges.command),
        ] {
            Allowed::Above(0.0).check(name, range)?;
        }
        if let Some(limit) = limit {
            Allowed::AtLeast(limit).check("ranges.command", ranges.command)?;
        }
        let (least_apart, most_apart) = APART;
        let given = exponent_above(ranges.error * units.position());
        // Half for the command that acted, the rest for the correction.
        let half = exponent_above(limit.unwrap_or(ranges.command));
        let mut command = exponent_above(ranges.command).max(half + 1);
        let (mut velocity, mut position) = (1, given);
        // Each full scale depends on the next: they agree in the first round, unless the integral of
        // one sample's error commands more than full scale.
        for _ in 0..Self::ROUNDS {
            for gains in gains.clone().filter(|gains| gains.ki() > 0.0) {
                let per_error = exponent_above(per_error(units, gains));
                command = command.max(per_error + position + least_apart + 1);
            }
            velocity = [
                exponent_above(ranges.velocity * units.velocity()),
                exponent_above(fastest),
                // b and b u at most one half; friction and load a sixteenth.
                b + command + 1,
                coulomb + 4,
                load + 4,
            ]
            .into_iter()
            // A standstill's slip is at most half of it.
            .fold(3, i32::max);
            position = given.max(velocity + least_apart);
        }
        let most = power(Self::WORD_BITS - Self::BELOW_A_COUNT) * units.position_unit();
        let needed = ranges
            .error
            .max(power(position - 1) * units.position_unit());
        Allowed::AtMost(most).check("ranges.error", needed)?;
        if position - velocity > most_apart {
            let least = ranges.error / units.rate() * power(-most_apart);
            Allowed::AtLeast(least).check("ranges.velocity", ranges.velocity)?;
        }
        let scales = Self {
            position,
            velocity,
            command,
        };
        for gains in gains {
            if sum_exponent(units, gains, &scales) > position + most_apart {
                let least =
                    power(command - 1 - position - most_apart) * units.position() / gains.ki();
                Allowed::AtLeast(least).check("sample_time", units.sample_time())?;
            }
        }
        Ok(scales)
    }
}
