//! The PID's loop in fixed point, with the Γ-gradient identifier beside it.

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::fixed_point::{
    FixedServoLoop, FixedServoLoopState, FixedVelocity, split_setpoint,
};
use identifier_core::identifier::Identify;
use identifier_core::parameters::ParameterSet;
use identifier_core::settings::SettingsError;

use super::learner::gamma_of;
use super::{Measurement, SimLoop, Step};
use crate::experiment::Outcome;

/// Controller and identifier on words.
pub(crate) struct FixedLoop<V: FixedVelocity, S, const P: usize> {
    servo_loop: FixedServoLoop<V, S, P>,
    state: FixedServoLoopState<V::State, P>,
    start: i32,
    gamma: Option<Vec<Vec<f64>>>,
}

impl<V: FixedVelocity, S: ParameterSet<P>, const P: usize> FixedLoop<V, S, P> {
    /// At rest at a count.
    ///
    /// # Errors
    /// What does not fit words, and what would.
    pub(crate) fn new(settings: &Settings, start: i32) -> Result<Self, SettingsError> {
        let servo_loop: FixedServoLoop<V, S, P> = settings.build()?;
        Ok(Self {
            state: servo_loop.start(start),
            servo_loop,
            start,
            gamma: gamma_of::<S, P>(settings),
        })
    }
}

impl<V: FixedVelocity, S: ParameterSet<P>, const P: usize> SimLoop for FixedLoop<V, S, P> {
    type Error = StepError;

    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let (whole, part) = split_setpoint(reference);
        let setpoint = self.start.wrapping_add(whole);
        let count = measured.count();
        let step = self
            .servo_loop
            .process(&mut self.state, setpoint, part, count)?;
        let (controller, identifier) = (self.servo_loop.controller(), self.servo_loop.identifier());
        Ok(Step {
            command: controller.command(step.control.command),
            velocity: Some(controller.velocity(step.control.velocity)),
            output_error: Some(identifier.output_error(&step.seen)),
            event: Some(step.seen.event),
            estimates: identifier.estimates(self.state.identification()),
            standard_errors: None,
            at_bounds: identifier.at_bounds(self.state.identification()),
        })
    }

    fn outcome(&self) -> Outcome {
        let identifier = self.servo_loop.identifier();
        Outcome {
            gamma: self.gamma.clone(),
            mu: Some(identifier.mu()),
            certified: identifier.certificate().is_some(),
            gain_margin: identifier.gain_margin(),
            ..Outcome::default()
        }
    }
}
