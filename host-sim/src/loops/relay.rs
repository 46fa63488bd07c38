//! The loop closed by a relay. The command is ± its level by the sign of q_d − q, and the servo oscillates around the
//! scenario's reference, as in the paper.

use identifier_core::error::StepError;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use rivals::{FilteredLeastSquares, FilteredLeastSquaresState, Relay};

use super::feedback::Feedback;
use super::identifier::Innovation;
use super::{DynIdentifier, Measurement, NO_ESTIMATE, SimLoop, Step};

/// Recursive least squares on filtered signals beside a relay.
pub(crate) struct RelayLoop<N: Number> {
    relay: Relay<N>,
    law: FilteredLeastSquares<N>,
    state: FilteredLeastSquaresState<N>,
    feedback: Feedback<N>,
}

impl<N: Number> RelayLoop<N> {
    /// At rest at zero.
    pub(crate) fn new(relay: Relay<N>, law: FilteredLeastSquares<N>) -> Self {
        Self {
            relay,
            state: law.start(),
            law,
            feedback: Feedback::starting_at(0),
        }
    }
}

impl<N: Number> SimLoop for RelayLoop<N> {
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let motion = self.feedback.read(reference, measured);
        let command = self.relay.command(motion.error);
        self.law.process(&mut self.state, motion.increment, command);
        let estimates = self.law.estimates(&self.state);
        Ok(Step::direct(command.to_f64(), estimates))
    }
}

/// The least squares beside a controller. A log that begins again continues for it.
pub(crate) struct DirectEstimator<N: Number> {
    law: FilteredLeastSquares<N>,
    state: FilteredLeastSquaresState<N>,
}

impl<N: Number> DirectEstimator<N> {
    pub(crate) fn new(law: FilteredLeastSquares<N>) -> Self {
        let state = law.start();
        Self { law, state }
    }
}

impl<N: Number> DynIdentifier for DirectEstimator<N> {
    fn update(&mut self, increment: f64, command: f64) -> Result<Innovation, StepError> {
        let (increment, command) = (N::from_f64(increment), N::from_f64(command));
        self.law.process(&mut self.state, increment, command);
        Ok(Innovation {
            command: command.to_f64(),
            update: None,
        })
    }

    fn estimates(&self) -> ServoParameters {
        self.law.estimates(&self.state).unwrap_or(NO_ESTIMATE)
    }
}
