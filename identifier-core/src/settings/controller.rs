use super::full_scales::full_scales;
use super::{FromSettings, Settings, SettingsError};
use crate::control::{Controller, Pid, Shaped};
use crate::error::Allowed;
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Arithmetic;

impl<N: Arithmetic, V: VelocityEstimate<N>> FromSettings for Controller<N, V> {
    /// # Errors
    /// A setting out of range, or one that asks for a [`Shaped`] controller. In fixed point also a range, bound or
    /// sample time that does not fit, with a value that would.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        match settings.own_controller()?.shaping_setting() {
            Some(setting) => Err(SettingsError::NotShaped { setting }),
            None => pid(settings),
        }
    }
}

impl<N: Arithmetic, V: VelocityEstimate<N>> FromSettings for Controller<N, V, Shaped<N>> {
    /// # Errors
    /// As for a controller that is not shaped. A notch or a feed-forward does not exist in fixed point.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let controller: Self = pid(settings)?;
        let given = settings.own_controller()?;
        if N::IS_FIXED {
            if let Some(feed_forward) = &given.feed_forward {
                Allowed::Within(0.0, 0.0)
                    .check("feed_forward.bandwidth", feed_forward.bandwidth)?;
            }
            Allowed::Within(0.0, 0.0).check("notch", given.notch)?;
        }
        let transfer = controller.velocity.transfer();
        Ok(controller.with_shaping(given.shaping(&settings.units()?, &transfer)?))
    }
}

/// The controller without a shaping.
fn pid<N, V, S>(settings: &Settings) -> Result<Controller<N, V, S>, SettingsError>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    S: Default,
{
    let given = settings.own_controller()?;
    let (gains, limit) = (given.gains()?, given.command_limit()?);
    let units = settings.units()?;
    let scales = full_scales::<N>(settings)?;
    let most = settings.most_increment(&units, N::REACH.value(scales.velocity))?;
    let velocity = settings.velocity::<N, V>()?;
    let pid = Pid::new(&units, &gains, &limit, &scales);
    Ok(Controller::with_pid(pid, velocity, scales).with_most_increment(most))
}
