//! The loop closed by a relay: the command is ± its level by the sign of q_d − q.
//!
//! The relay's least squares follows the scenario's reference and swings around it, as the paper
//! has it; limit cycles are left alone around a place that stands still.

use identifier_core::error::StepError;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use rivals::{
    DirectEstimator, FilteredLeastSquares, FilteredLeastSquaresState, Relay, RelayCycle,
    RelayCycleState, RelayState, TwoRelays, TwoRelaysState,
};

use super::feedback::Feedback;
use super::{Measurement, SimLoop, Step};
use crate::experiment::Outcome;

/// A method that closes its loop with a relay.
pub(crate) trait RelayMethod<N> {
    /// One sample: increment of the position and error to command.
    fn process(&mut self, increment: N, error: N) -> N;

    /// The estimates, SI, if there are any.
    fn estimates(&self) -> Option<ServoParameters>;

    /// Whether it follows the scenario's reference, or stays around zero.
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
    method: Box<dyn RelayMethod<N>>,
    feedback: Feedback<N>,
}

impl<N: Number> RelayLoop<N> {
    /// At rest at zero.
    pub(crate) fn new(method: Box<dyn RelayMethod<N>>) -> Self {
        Self {
            method,
            feedback: Feedback::starting_at(0),
        }
    }
}

impl<N: Number> SimLoop for RelayLoop<N> {
    type Error = StepError;

    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let motion = self.feedback.read(reference, measured);
        let command = self.method.process(motion.increment, motion.error);
        Ok(Step::direct(command.to_f64(), self.method.estimates()))
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

impl<N: Number> RelayMethod<N> for LeastSquares<N> {
    fn process(&mut self, increment: N, error: N) -> N {
        let command = self.relay.process(&mut self.relay_state, error);
        self.law.process(&mut self.state, increment, command);
        command
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

/// The limit cycle of one relay.
pub(crate) struct Cycle<N> {
    law: RelayCycle<N>,
    state: RelayCycleState<N>,
}

impl<N: Number> Cycle<N> {
    pub(crate) fn new(law: RelayCycle<N>) -> Self {
        Self {
            state: law.start(),
            law,
        }
    }
}

impl<N: Number> RelayMethod<N> for Cycle<N> {
    fn process(&mut self, increment: N, error: N) -> N {
        self.law.process(&mut self.state, increment, error)
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates(&self.state)
    }
}

/// The limit cycles of two.
pub(crate) struct TwoCycles<N> {
    law: TwoRelays<N>,
    state: TwoRelaysState<N>,
}

impl<N: Number> TwoCycles<N> {
    pub(crate) fn new(law: TwoRelays<N>) -> Self {
        Self {
            state: law.start(),
            law,
        }
    }
}

impl<N: Number> RelayMethod<N> for TwoCycles<N> {
    fn process(&mut self, increment: N, error: N) -> N {
        self.law.process(&mut self.state, increment, error)
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates(&self.state)
    }
}
