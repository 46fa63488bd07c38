use identifier_core::parameters::IdentifiedServo;
use identifier_core::tuning::AxisForces;

/// A servo that was fitted to a motion, and the forces on the axis beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FittedServo {
    pub(crate) servo: IdentifiedServo,
    pub(crate) forces: AxisForces,
    /// True if they explain the motion.
    pub(crate) explains: bool,
}
