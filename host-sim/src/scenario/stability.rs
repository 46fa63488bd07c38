//! Stability of the loop around the true servo.

use identifier_core::Settings;
use identifier_core::interval::Interval;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::settings::SettingsError;
use identifier_core::stability::SampledLoopError;
use identifier_core::stability::{ParameterRange, SampledLoop};

use super::dispatch::with_velocity;
use super::{LoopKind, Scenario};

impl Scenario {
    /// Why a loop cannot hold its servo; none where it can, or where another than
    /// a PID closes it. A simulated encoder never fails, so this is why a run leaves every range.
    #[must_use]
    pub fn unstable_loop(&self) -> Option<SampledLoopError> {
        let servo = self.plant.as_ref()?;
        let closing = self.identifier.law.closing();
        if closing == LoopKind::Relay {
            return None;
        }
        match with_velocity!(self, f64 => check(&self.stated, servo.a, servo.b)) {
            Err(SettingsError::SampledLoop(error)) => Some(error),
            _ => None,
        }
    }
}

fn check<V: VelocityEstimate<f64>>(
    settings: &Settings,
    a: f64,
    b: f64,
) -> Result<(), SettingsError> {
    let velocity = settings.velocity::<f64, V>()?;
    let servo = ParameterRange::new(Interval::new("a", a, a)?, Interval::new("b", b, b)?)?;
    let gains = settings.own_controller()?.gains()?;
    let units = settings.units()?;
    SampledLoop::new(&units, &gains, &velocity.transfer()).check(&servo)?;
    Ok(())
}
