//! A controller whose feed-forward compensates known forces.

use identifier_core::Settings;
use identifier_core::control::{CompensatedFeedForward, CompensationSettings, Controller, Lead};
use identifier_core::measurement::{Transfer, VelocityEstimate};
use identifier_core::number::Number;
use identifier_core::settings::SettingsError;

/// The controller of settings whose feed-forward compensates known forces.
///
/// # Errors
/// The setting that it cannot be built from.
pub(crate) fn compensated<N: Number, V: VelocityEstimate<N>>(
    settings: &Settings,
    known: &CompensationSettings,
) -> Result<Controller<N, V, CompensatedFeedForward<N>>, SettingsError> {
    let controller: Controller<N, V> = settings.build()?;
    let lead = lead(settings, known, &controller.velocity.transfer())?;
    Ok(controller.with_feed_forward(lead))
}

/// The feed-forward of settings with the compensation of known forces, if any are.
fn lead<N: Number>(
    settings: &Settings,
    known: &CompensationSettings,
    velocity: &Transfer,
) -> Result<CompensatedFeedForward<N>, SettingsError> {
    let pid = settings.own_controller()?;
    let Some(led) = &pid.feed_forward else {
        return Ok(Lead::NONE);
    };
    let (units, gains) = (settings.units()?, pid.gains()?);
    Ok(CompensatedFeedForward::new(
        &units, led, known, &gains, velocity,
    )?)
}
