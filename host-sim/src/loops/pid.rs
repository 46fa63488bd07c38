//! The PID's loop with an identifier beside it, in floating point.

use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::error::StepError;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::settings::SettingsError;

use super::feedback::Feedback;
use super::{Learner, Measurement, SimLoop, Step};
use crate::experiment::Outcome;

/// A PID controller, and what learns from its commands.
pub(crate) struct PidLoop<N: Number, V: VelocityEstimate<N>> {
    controller: Controller<N, V>,
    control: ControlState<N, V::State>,
    feedback: Feedback<N>,
    learner: Box<dyn Learner<N>>,
}

impl<N: Number, V: VelocityEstimate<N>> PidLoop<N, V> {
    /// At rest at a count.
    ///
    /// # Errors
    /// What the controller cannot be built from.
    pub(crate) fn new(
        settings: &Settings,
        learner: Box<dyn Learner<N>>,
        start: i32,
    ) -> Result<Self, SettingsError> {
        Ok(Self {
            controller: settings.build()?,
            control: ControlState::default(),
            feedback: Feedback::starting_at(start),
            learner,
        })
    }
}

impl<N: Number, V: VelocityEstimate<N>> SimLoop for PidLoop<N, V> {
    type Error = StepError;

    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let motion = self.feedback.read(reference, measured);
        let control = self
            .controller
            .process(&mut self.control, motion.error, motion.increment)?;
        let learner = &mut self.learner;
        let seen = learner.learn(control.increment, control.command)?;
        learner.work();
        Ok(Step {
            command: control.command.to_f64(),
            velocity: Some(control.velocity.to_f64()),
            output_error: seen.map(|seen| seen.output_error.to_f64()),
            event: seen.map(|seen| seen.event),
            estimates: learner.estimates(),
            standard_errors: learner.standard_errors(),
            at_bounds: learner.at_bounds(),
        })
    }

    fn outcome(&self) -> Outcome {
        self.learner.outcome()
    }
}
