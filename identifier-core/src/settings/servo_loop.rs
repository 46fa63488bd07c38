use super::{FromSettings, Settings, SettingsError};
use crate::identifier::{Combined, Identify, ServoLoop};
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Arithmetic;

impl<N, V, I> FromSettings for ServoLoop<N, V, I>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    I: Identify<N> + FromSettings,
{
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        Ok(Self {
            controller: settings.build()?,
            identifier: settings.build()?,
        })
    }
}

impl<R: FromSettings, F: FromSettings> FromSettings for Combined<R, F> {
    /// # Errors
    /// See [`SettingsError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        Ok(Self {
            recorder: settings.build()?,
            fitter: settings.build()?,
        })
    }
}
