use identifier_core::baseline::DirectEstimator;
use identifier_core::control::{ControlSample, ControlState};
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;

use super::NO_ESTIMATE;
use crate::experiment::learner::{Given, Learner, Seen};

/// A direct estimator beside a controller.
pub(super) struct DirectLearner<N: Number, E: DirectEstimator<N>> {
    estimator: E,
    state: E::State,
}

impl<N: Number, E: DirectEstimator<N>> DirectLearner<N, E> {
    pub(super) fn new(estimator: E) -> Self {
        Self {
            state: estimator.start(),
            estimator,
        }
    }
}

impl<N: Number, F, E: DirectEstimator<N>> Learner<N, F> for DirectLearner<N, E> {
    fn process(&mut self, _: &Given<N, F>, real: &ControlSample<N>) -> Seen<N> {
        let command = real.command + real.injection;
        self.estimator
            .process(&mut self.state, real.increment, command);
        Seen::nothing()
    }

    fn estimates(&self) -> ServoParameters {
        self.estimator.estimates(&self.state).unwrap_or(NO_ESTIMATE)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        None
    }

    /// A log that begins again goes on for it: the jump of the position is in the first increment,
    /// which the controller's state has already left behind.
    fn join(&mut self, _: &ControlState<N, F>) {}
}
