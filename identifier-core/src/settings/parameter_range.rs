use super::{Settings, SettingsError};
use crate::error::OutOfRange;
use crate::interval::Interval;
use crate::stability::ParameterRange;

/// The smallest b̂, SI, if no bound is given.
pub(super) const SMALLEST_GAIN: f64 = 1e-6;

/// The parameter range of a configuration.
pub(crate) fn parameter_range(settings: &Settings) -> Result<Option<ParameterRange>, OutOfRange> {
    let Some(given) = settings.identifier.parameter_range else {
        return Ok(None);
    };
    let side = |name, [min, max]: [f64; 2]| Interval::new(name, min, max);
    let parameter_range = ParameterRange::new(
        side("servo_range.a", given.a)?,
        side("servo_range.b", given.b)?,
    )?;
    Ok(Some(parameter_range))
}

/// The parameter range, or the servo of the initial estimates.
///
/// # Errors
/// [`SettingsError::NotGiven`] if there are neither.
pub(crate) fn nominal_range(settings: &Settings) -> Result<ParameterRange, SettingsError> {
    if let Some(given) = parameter_range(settings)? {
        return Ok(given);
    }
    let point = |name, value| Interval::new(name, value, value);
    let Some(b) = settings.identifier.initial.b else {
        return Err(SettingsError::NotGiven {
            setting: "initial.b",
        });
    };
    let a = settings.identifier.initial.a.unwrap_or(0.0).max(0.0);
    Ok(ParameterRange::new(
        point("initial.a", a)?,
        point("initial.b", b)?,
    )?)
}
