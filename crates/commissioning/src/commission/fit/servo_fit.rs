use super::motion_model::{MotionFit, MotionFitter, UNKNOWNS};
use identifier_core::fit::FitResult;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::AxisForces;

/// A servo that was fitted to a motion, and the forces on the axis beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FittedServo {
    pub(crate) servo: IdentifiedServo,
    pub(crate) forces: AxisForces,
    /// True if they explain the motion.
    pub(crate) explains: bool,
}

/// A fit under way, and then the prediction of its own motion by the result, in the same memory: only position and
/// velocity at its beginning are estimated then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoFit<N> {
    pub(super) fitter: MotionFitter<N>,
    pub(super) fit: MotionFit<N>,
    /// The result, and the sum of the squares of the errors of its prediction so far.
    pub(super) found: Option<(FitResult<N, UNKNOWNS>, N)>,
    /// The forces that are fitted beside the servo: the place in the list of the fitter.
    pub(super) forces: usize,
    /// What was found without any.
    pub(super) plain: Option<Result<FittedServo, Reason>>,
}
