use super::full_scales::full_scales;
use super::{FromSettings, Settings, SettingsError};
use crate::control::{Controller, Pid};
use crate::error::Allowed;
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Arithmetic;

impl<N: Arithmetic, V: VelocityEstimate<N>> FromSettings for Controller<N, V> {
    /// # Errors
    /// A setting out of range. In fixed point also a range, bound or sample time that does not fit, with a value that
    /// would. A notch or a feed-forward does not exist there.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let given = settings.own_controller()?;
        let (gains, limit) = (given.gains()?, given.command_limit()?);
        let units = settings.units()?;
        if N::IS_FIXED {
            if let Some(feed_forward) = &given.feed_forward {
                Allowed::Within(0.0, 0.0)
                    .check("feed_forward.bandwidth", feed_forward.bandwidth)?;
            }
            Allowed::Within(0.0, 0.0).check("notch", given.notch)?;
        }
        let scales = full_scales::<N>(settings)?;
        let most = settings.most_increment(&units, N::REACH.value(scales.velocity))?;
        let velocity = settings.velocity::<N, V>()?;
        let pid = Pid::new(&units, &gains, &limit, &scales);
        Ok(Self::with_pid(pid, velocity, scales)
            .with_most_increment(most)
            .with_reference_filter(given.reference_filter(&units)?)
            .with_feed_forward(given.feed_forward(&units, &velocity.transfer())?)
            .with_notch(given.notch(&units)?))
    }
}
