use identifier_core::error::StepError;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use rivals::DirectEstimator;

use super::{DynIdentifier, Innovation, NO_ESTIMATE};

/// A direct estimator beside a controller. A log that begins again continues for it.
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

impl<N: Number, E: DirectEstimator<N>> DynIdentifier for Direct<N, E> {
    fn update(&mut self, increment: f64, command: f64) -> Result<Innovation, StepError> {
        let (increment, command) = (N::from_f64(increment), N::from_f64(command));
        self.estimator.process(&mut self.state, increment, command);
        Ok(Innovation {
            command: command.to_f64(),
            update: None,
        })
    }

    fn estimates(&self) -> ServoParameters {
        self.estimator.estimates(&self.state).unwrap_or(NO_ESTIMATE)
    }
}
