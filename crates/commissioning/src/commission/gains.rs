use super::Limits;
use identifier_core::Settings;
use identifier_core::control::{Controller, Shaped};
use identifier_core::error::OutOfRange;
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::number::Number;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::Tuning;
use identifier_core::units::Units;

/// The PID that every half of a commissioning closes: with a low-pass velocity estimate.
pub(super) type Loop<N> = Controller<N, LowPass<N>, Shaped<N>>;

/// The state of that estimate.
pub(super) type Velocity<N> = <LowPass<N> as VelocityEstimate<N>>::State;

/// Gains that hold a servo, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HoldingGains {
    /// The PID.
    pub controller: ControllerSettings,
    /// The cut-off of its velocity estimate, rad/s.
    pub cutoff: f64,
}

impl HoldingGains {
    /// The gains of a loop's settings, if a PID closes it.
    #[must_use]
    pub fn of(settings: &Settings) -> Option<Self> {
        settings.controller.map(|controller| Self {
            controller,
            cutoff: settings.cutoff,
        })
    }

    /// Those that were tuned.
    pub(super) fn tuned(tuning: &Tuning, limits: &Limits) -> Self {
        Self {
            controller: ControllerSettings::tuned(tuning, limits.command),
            cutoff: tuning.cutoff,
        }
    }

    /// The loop in machine units.
    ///
    /// # Errors
    /// The gain or the cut-off that is out of its range.
    pub(super) fn build<N: Number>(&self, units: &Units) -> Result<Loop<N>, OutOfRange> {
        let given = &self.controller;
        let (gains, limit) = (given.gains()?, given.command_limit()?);
        let velocity = LowPass::new(units, self.cutoff)?;
        let shaping = given.shaping(units, &velocity.transfer())?;
        Ok(Controller::new(units, &gains, &limit, velocity).with_shaping(shaping))
    }
}
