//! The loop closed by a relay. The command is ± its level by the sign of q_d − q, and the servo oscillates around the
//! scenario's reference, as in the paper.

use identifier_core::error::StepError;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use rivals::{FilteredLeastSquares, FilteredLeastSquaresState, Relay};

use super::feedback::Feedback;
use super::{Measurement, SimLoop, Step};

/// A method that closes its loop with a relay.
pub(crate) trait RelayMethod {
    /// One sample: increment of the position and error to command.
    fn process(&mut self, increment: f64, error: f64) -> f64;

    /// The estimates, SI, if there are any.
    fn estimates(&self) -> Option<ServoParameters>;
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
}

/// Recursive least squares on filtered signals beside a relay.
pub(crate) struct LeastSquares<N: Number> {
    relay: Relay<N>,
    law: FilteredLeastSquares<N>,
    state: FilteredLeastSquaresState<N>,
}

impl<N: Number> LeastSquares<N> {
    pub(crate) fn new(relay: Relay<N>, law: FilteredLeastSquares<N>) -> Self {
        Self {
            relay,
            state: law.start(),
            law,
        }
    }
}

impl<N: Number> RelayMethod for LeastSquares<N> {
    fn process(&mut self, increment: f64, error: f64) -> f64 {
        let command = self.relay.command(N::from_f64(error));
        let increment = N::from_f64(increment);
        self.law.process(&mut self.state, increment, command);
        command.to_f64()
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates(&self.state)
    }
}
