//! The paper's Γ-gradient: estimator (11), stability certificate (14), projection into the bounds, and the identifier that
//! runs them.

mod certificate;
mod config;
mod identifier;
mod law;
mod memory;
mod parameter_range;
mod projection;
mod recursion;

pub(crate) use certificate::automatic_mu;
pub use certificate::{Certificate, CertificateError};
pub(crate) use config::GradientConfig;
pub use identifier::GradientIdentifier;
pub(crate) use law::Gradient;
pub use memory::{GradientCorrection, GradientMemory, GradientMemoryState};
pub use parameter_range::ParameterRange;
pub use recursion::GradientRecursion;
pub(crate) use recursion::StabilityCheck;
