use super::{FromSettings, Settings, SettingsError};
use crate::control::{Controller, Pid};
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Number;

impl<N: Number, V: VelocityEstimate<N>> FromSettings for Controller<N, V> {
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let given = settings.own_controller()?;
        let (gains, limit) = (given.gains()?, given.command_limit()?);
        let units = settings.units()?;
        let most = settings.most_increment(&units, N::REACH.to_f64())?;
        let velocity = settings.velocity::<N, V>()?;
        Ok(Self {
            pid: Pid::new(&units, &gains, &limit),
            reference: given.reference_filter(&units)?,
            feed_forward: given.feed_forward(&units, &velocity.transfer())?,
            notch: given.notch(&units)?,
            velocity,
            jump: N::from_f64(N::REACH.to_f64() / most),
        })
    }
}
