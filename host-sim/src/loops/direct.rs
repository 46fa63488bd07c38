use identifier_core::error::StepError;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use rivals::{FilteredLeastSquares, FilteredLeastSquaresState};

use super::{DynIdentifier, Innovation, NO_ESTIMATE};

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
