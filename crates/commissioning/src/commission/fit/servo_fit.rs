use super::PARAMETERS;
use super::motion_model::{MotionFit, MotionFitter};
use super::prediction::PredictionRun;
use identifier_core::fit::FitResult;

/// A fit under way, and then the prediction of its own motion by the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoFit<N> {
    pub(super) fitter: MotionFitter<N>,
    pub(super) fit: MotionFit<N>,
    pub(super) found: Option<(FitResult<N, PARAMETERS>, PredictionRun<N>)>,
}
