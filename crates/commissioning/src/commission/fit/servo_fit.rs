use super::prediction::PredictionRun;
use super::{DELAY, PARAMETERS};
use identifier_core::fit::{Fit, FitResult, Fitter};
use identifier_core::identifier::DelayedInputs;
use identifier_core::number::Number;
use identifier_core::parameters::Unknowns;

/// The model of a motion: a, b, c, the delay and d.
pub(super) type MotionModel = Unknowns<5>;

/// Its last commands.
pub(super) type MotionInputs<N> = DelayedInputs<N, 8>;

/// A fitter of it.
pub(super) type MotionFitter<N> = Fitter<N, MotionModel, PARAMETERS>;

/// A fit of it under way.
pub(super) type MotionFit<N> = Fit<N, MotionInputs<N>, PARAMETERS>;

/// A fit under way, and then the prediction of its own motion by the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoFit<N> {
    pub(super) fitter: MotionFitter<N>,
    pub(super) fit: MotionFit<N>,
    /// Samples.
    pub(super) expected_delay: N,
    pub(super) found: Option<(FitResult<N, PARAMETERS>, PredictionRun<N>)>,
}

impl<N: Number> ServoFit<N> {
    /// What the linear pass has found, machine units of a sample; zero before.
    pub(super) fn linear_estimate(&self) -> [N; PARAMETERS] {
        let mut estimate = self.fitter.linear_estimate(&self.fit);
        estimate[DELAY] = self.expected_delay;
        estimate
    }
}
