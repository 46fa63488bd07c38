//! The loop closed by a relay: the command is ± its level by the sign of q_d − q.
//!
//! The relay's least squares follows the scenario's reference and swings around it, as the paper
//! has it; limit cycles are left alone around a place that stands still.

use identifier_core::error::StepError;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use rivals::{
    DirectEstimator, FilteredLeastSquares, FilteredLeastSquaresState, Relay, RelayCycles,
    RelayCyclesState, RelayState,
};

use super::feedback::Feedback;
use super::{Measurement, SimLoop, Step};
use crate::experiment::Outcome;

/// A method that closes its loop with a relay.
pub(crate) trait RelayMethod {
    /// One sample: increment of the position and error to command.
    fn process(&mut self, increment: f64, error: f64) -> f64;

    /// The estimates, SI, if there are any.
    fn estimates(&self) -> Option<ServoParameters>;

    /// True if it follows the scenario's reference, false if it stays around zero.
    fn follows(&self) -> bool {
        false
    }

    /// Why it has no estimates, if it has none.
    fn failure(&self) -> Option<&'static str> {
        self.estimates()
            .is_none()
            .then_some("the limit cycle did not become steady")
    }
}

/// Its loop.
pub(crate) struct RelayLoop<N> {
    method: Box<dyn RelayMethod>,
    feedback: Feedback<N>,
}

impl<N: Number> RelayLoop<N> {
    /// At rest at zero.
    pub(crate) fn new(method: Box<dyn RelayMethod>) -> Self {
        Self {
            method,
            feedback: Feedback::starting_at(0),
        }
    }
}

impl<N: Number> SimLoop for RelayLoop<N> {
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let motion = self.feedback.read(reference, measured);
        let (increment, error) = (motion.increment.to_f64(), motion.error.to_f64());
        let command = self.method.process(increment, error);
        Ok(Step::direct(command, self.method.estimates()))
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            failure: self.method.failure(),
            ..Outcome::default()
        }
    }
}

/// Recursive least squares on filtered signals beside a relay.
pub(crate) struct LeastSquares<N: Number> {
    relay: Relay<N>,
    relay_state: RelayState,
    law: FilteredLeastSquares<N>,
    state: FilteredLeastSquaresState<N>,
}

impl<N: Number> LeastSquares<N> {
    pub(crate) fn new(relay: Relay<N>, law: FilteredLeastSquares<N>) -> Self {
        Self {
            relay_state: relay.start(),
            relay,
            state: law.start(),
            law,
        }
    }
}

impl<N: Number> RelayMethod for LeastSquares<N> {
    fn process(&mut self, increment: f64, error: f64) -> f64 {
        let error = N::from_f64(error);
        let command = self.relay.process(&mut self.relay_state, error);
        let increment = N::from_f64(increment);
        self.law.process(&mut self.state, increment, command);
        command.to_f64()
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates(&self.state)
    }

    fn follows(&self) -> bool {
        true
    }

    fn failure(&self) -> Option<&'static str> {
        None
    }
}

/// The limit cycles of one relay or of two.
impl<N: Number, const R: usize> RelayMethod for (RelayCycles<N, R>, RelayCyclesState<N, R>) {
    fn process(&mut self, increment: f64, error: f64) -> f64 {
        let (law, state) = self;
        let command = law.process(state, N::from_f64(increment), N::from_f64(error));
        command.to_f64()
    }

    fn estimates(&self) -> Option<ServoParameters> {
        let (law, state) = self;
        law.estimates(state)
    }
}
