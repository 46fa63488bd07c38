use super::{Settings, SettingsError};
use crate::control::Gains;
use crate::error::{Allowed, OutOfRange};
use crate::interval::Interval;
use crate::model::ZeroOrderHoldStep;
use crate::parameters::Parameter;
use crate::stability::ParameterRange;
use crate::units::Units;

/// The smallest b̂, SI, if no bound is given.
pub(super) const SMALLEST_GAIN: f64 = 1e-6;

/// The largest b̂, ĉ and |d̂|, SI. They are far beyond any servo, and keep the model loop in the range of single
/// precision.
pub(super) const LARGEST: f64 = Gains::LARGEST;

/// The range of an estimate, and the names of bounds and initial value.
pub(super) fn allowed(
    parameter: Parameter,
    units: &Units,
) -> (Allowed, &'static str, &'static str) {
    let fastest = ZeroOrderHoldStep::<f64>::LARGEST_RATE / units.rate();
    match parameter {
        Parameter::A => (Allowed::Within(-fastest, fastest), "bounds.a", "initial.a"),
        Parameter::B => (Allowed::PositiveUpTo(LARGEST), "bounds.b", "initial.b"),
        Parameter::Coulomb => (
            Allowed::Within(0.0, LARGEST),
            "bounds.coulomb",
            "initial.coulomb",
        ),
        Parameter::Load => (
            Allowed::Within(-LARGEST, LARGEST),
            "bounds.load",
            "initial.load",
        ),
    }
}

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
