//! Identifiers: a model and an estimator for a servo whose loop a controller closes.
//!
//! All of them [`Identify`]: they get the encoder's increment and the command that acts, and nothing else.
//! [`GradientIdentifier`] runs the paper's estimator with a memory. [`GaussNewtonIdentifier`] is the fast one, with standard errors;
//! it begins without a guess. It also exists as two halves: an interrupt that [records](GaussNewtonRecursion) and a
//! background that [fits](GaussNewtonFitter). [`ServoLoop`] is our controller with one of them. An [`Amplifier`](crate::model::Amplifier)
//! gives them the command that acts behind its known effects.

pub use crate::fit::block::NumberedBlock;
pub use crate::gradient::{
    GradientCorrection, GradientIdentifier, GradientMemory, GradientMemoryState, GradientRecursion,
};
pub use crate::identify::{Event, Identify, MachineEstimates, Report, Update};
pub use crate::model::identifiable_set::IdentifiableSet;
pub use crate::model::known_inputs::{AngledInputs, DelayedInputs};
pub use crate::recursive::{
    ExpectedMotion, GaussNewtonFitted, GaussNewtonFitter, GaussNewtonFitterState,
    GaussNewtonIdentifier, GaussNewtonRecursion, PreparedServo, SettledEstimates,
};
pub use crate::servo_loop::{LoopStep, ServoLoop, ServoLoopState};
pub use crate::windows::MeasuredPiece;
