//! The PID's loop with an identifier beside it, in floating point.

use identifier_core::control::{ControlState, Controller, Shaped, ShapedState};
use identifier_core::error::StepError;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::number::Number;

use super::feedback::Feedback;
use super::{DynIdentifier, Measurement, SimLoop, Step};
use identifier_log::experiment::Outcome;

/// A PID controller, and the identifier of its commands.
pub(crate) struct PidLoop<N: Number, V: VelocityEstimate<N>> {
    controller: Controller<N, V, Shaped<N>>,
    control: ControlState<N, V::State, ShapedState<N>>,
    feedback: Feedback<N>,
    identifier: Box<dyn DynIdentifier>,
}

impl<N: Number, V: VelocityEstimate<N>> PidLoop<N, V> {
    /// At rest at a count.
    pub(crate) fn new(
        controller: Controller<N, V, Shaped<N>>,
        identifier: Box<dyn DynIdentifier>,
        start: i32,
    ) -> Self {
        Self {
            control: controller.start(),
            controller,
            feedback: Feedback::starting_at(start),
            identifier,
        }
    }
}

impl<N: Number, V: VelocityEstimate<N>> SimLoop for PidLoop<N, V> {
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let motion = self.feedback.read(reference, measured);
        let control = self
            .controller
            .process(&mut self.control, motion.error, motion.increment)?;
        let (increment, command) = (control.increment.to_f64(), control.command.to_f64());
        let velocity = Some(control.velocity.to_f64());
        self.identifier.step(increment, command, velocity)
    }

    fn outcome(&self) -> Outcome {
        self.identifier.outcome()
    }
}
