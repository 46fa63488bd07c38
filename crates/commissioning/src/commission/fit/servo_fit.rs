use super::force_search::ForceSearch;
use super::motion_model::{MotionFit, MotionFitter, UNKNOWNS};
use identifier_core::fit::FitResult;

/// A fit under way, and then the prediction of its own motion by the result, in the same memory: only position and
/// velocity at its beginning are estimated then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoFit<N> {
    pub(super) fitter: MotionFitter<N>,
    pub(super) fit: MotionFit<N>,
    /// The result, and the sum of the squares of the errors of its prediction so far.
    pub(super) found: Option<(FitResult<N, UNKNOWNS>, N)>,
    /// The search for forces beside the servo.
    pub(super) search: ForceSearch,
}
