use super::{Settings, SettingsError};
use crate::error::OutOfRange;
use crate::interval::Interval;
use crate::stability::PlantBox;

/// The smallest b̂, SI, if no bound is given.
pub(super) const SMALLEST_GAIN: f64 = 1e-6;

/// The parameter range of a configuration.
pub(crate) fn plant_box(settings: &Settings) -> Result<Option<PlantBox>, OutOfRange> {
    let Some(given) = settings.identifier.plant_box else {
        return Ok(None);
    };
    let side = |name, [min, max]: [f64; 2]| Interval::new(name, min, max);
    let plant_box = PlantBox::new(side("plant_box.a", given.a)?, side("plant_box.b", given.b)?)?;
    Ok(Some(plant_box))
}

/// The parameter range, or the servo of the initial estimates.
///
/// # Errors
/// [`SettingsError::NotGiven`] if there are neither.
pub(crate) fn nominal_box(settings: &Settings) -> Result<PlantBox, SettingsError> {
    if let Some(given) = plant_box(settings)? {
        return Ok(given);
    }
    let point = |name, value| Interval::new(name, value, value);
    let Some(b) = settings.identifier.initial.b else {
        return Err(SettingsError::NotGiven {
            setting: "initial.b",
        });
    };
    let a = settings.identifier.initial.a.unwrap_or(0.0).max(0.0);
    Ok(PlantBox::new(
        point("initial.a", a)?,
        point("initial.b", b)?,
    )?)
}
