use super::motion_model::{MotionFit, MotionFitter};
use super::prediction::PredictionRun;
use super::{DELAY, PARAMETERS};
use identifier_core::fit::FitResult;
use identifier_core::number::Number;

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
    /// The estimate of the linear pass, machine units of a sample; zero before.
    pub(super) fn linear_estimate(&self) -> [N; PARAMETERS] {
        let mut estimate = self.fitter.linear_estimate(&self.fit);
        estimate[DELAY] = self.expected_delay;
        estimate
    }
}
