use super::{FromSettings, Settings, SettingsError};
use crate::control::Controller;
use crate::identify::Identify;
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Arithmetic;
use crate::servo_loop::ServoLoop;

impl<N, V, I, S> FromSettings for ServoLoop<N, V, I, S>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    I: Identify<N> + FromSettings,
    Controller<N, V, S>: FromSettings,
{
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        Ok(Self {
            controller: settings.build()?,
            identifier: settings.build()?,
        })
    }
}
