use identifier_core::error::StepError;
use identifier_core::identifier::Update;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use rivals::DirectEstimator;

use super::{Learner, NO_ESTIMATE};

/// A direct estimator beside a controller.
pub(crate) struct Direct<N: Number, E: DirectEstimator<N>> {
    estimator: E,
    state: E::State,
}

impl<N: Number, E: DirectEstimator<N>> Direct<N, E> {
    pub(crate) fn new(estimator: E) -> Self {
        Self {
            state: estimator.start(),
            estimator,
        }
    }
}

impl<N: Number, E: DirectEstimator<N>> Learner<N> for Direct<N, E> {
    fn learn(&mut self, increment: N, command: N) -> Result<Option<Update<N>>, StepError> {
        self.estimator.process(&mut self.state, increment, command);
        Ok(None)
    }

    fn estimates(&self) -> ServoParameters {
        self.estimator.estimates(&self.state).unwrap_or(NO_ESTIMATE)
    }

    /// A log that begins again goes on for it.
    fn join(&mut self, _: N) {}
}
