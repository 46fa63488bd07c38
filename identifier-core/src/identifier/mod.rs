//! Identifiers: a model and an estimator for a servo whose loop a controller closes.
//!
//! All of them [`Identify`]: they get the encoder's increment and the command that acts, and nothing else.
//! [`GradientIdentifier`] runs the paper's estimator. [`GaussNewtonIdentifier`] is the fast one, with standard errors;
//! it begins without a guess. It also exists as two halves: an interrupt that [records](RecordBlocks) and a background
//! that [fits](FitBlocks). [`ServoLoop`] is our controller with one of them. An [`Amplifier`](crate::model::Amplifier)
//! gives them the command that acts behind its known effects.

mod combined;
mod gauss_newton;
mod gradient;
mod halves;
mod identify;
mod machine_estimates;
mod servo_loop;

pub use crate::adaptation::IdentifiableSet;
pub use crate::fit::block::NumberedBlock;
pub use crate::model::known_inputs::{AngledInputs, DelayedInputs};
pub use combined::Combined;
pub(crate) use gauss_newton::LoadStepTest;
pub use gauss_newton::{
    ExpectedMotion, GaussNewtonFitter, GaussNewtonIdentifier, GaussNewtonRecursion, PreparedServo,
    SettledEstimates,
};
pub use gradient::GradientIdentifier;
pub use halves::{FitBlocks, RecordBlocks};
pub use identify::{Event, Identify, Update};
pub use machine_estimates::MachineEstimates;
pub use servo_loop::{LoopStep, ServoLoop, ServoLoopState};
