//! The PID's loop with an identifier beside it, in floating point.

use identifier_core::Settings;
use identifier_core::control::{
    CompensatedFeedForward, CompensatedMotion, CompensationSettings, ControlState, Controller, Lead,
};
use identifier_core::error::StepError;
use identifier_core::measurement::{Transfer, VelocityEstimate};
use identifier_core::number::Number;
use identifier_core::settings::SettingsError;

use super::feedback::Feedback;
use super::{DynIdentifier, Measurement, SimLoop, Step};
use crate::experiment::Outcome;

/// A PID controller, and the identifier of its commands.
pub(crate) struct PidLoop<N: Number, V: VelocityEstimate<N>> {
    controller: Controller<N, V, CompensatedFeedForward<N>>,
    control: ControlState<N, V::State, CompensatedMotion<N>>,
    feedback: Feedback<N>,
    identifier: Box<dyn DynIdentifier>,
}

impl<N: Number, V: VelocityEstimate<N>> PidLoop<N, V> {
    /// At rest at a count.
    ///
    /// # Errors
    /// The setting that the controller cannot be built from.
    pub(crate) fn new(
        settings: &Settings,
        known: Option<&CompensationSettings>,
        identifier: Box<dyn DynIdentifier>,
        start: i32,
    ) -> Result<Self, SettingsError> {
        let controller: Controller<N, V> = settings.build()?;
        let lead = lead(settings, known, &controller.velocity.transfer())?;
        let controller = controller.with_feed_forward(lead);
        Ok(Self {
            control: controller.start(),
            controller,
            feedback: Feedback::starting_at(start),
            identifier,
        })
    }
}

/// The feed-forward of settings with the compensation of known forces, if any are.
fn lead<N: Number>(
    settings: &Settings,
    known: Option<&CompensationSettings>,
    velocity: &Transfer,
) -> Result<CompensatedFeedForward<N>, SettingsError> {
    let pid = settings.own_controller()?;
    let Some(led) = &pid.feed_forward else {
        return Ok(Lead::NONE);
    };
    let known = known.copied().unwrap_or(CompensationSettings::NONE);
    let (units, gains) = (settings.units()?, pid.gains()?);
    Ok(CompensatedFeedForward::new(
        &units, led, &known, &gains, velocity,
    )?)
}

impl<N: Number, V: VelocityEstimate<N>> SimLoop for PidLoop<N, V> {
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let motion = self.feedback.read(reference, measured);
        let control = self
            .controller
            .process(&mut self.control, motion.error, motion.increment)?;
        let (increment, command) = (control.increment.to_f64(), control.command.to_f64());
        Ok(Step {
            velocity: Some(control.velocity.to_f64()),
            ..self.identifier.step(increment, command)?
        })
    }

    fn outcome(&self) -> Outcome {
        self.identifier.outcome()
    }
}
