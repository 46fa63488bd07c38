//! Results of experiments, serialised unchanged, beside those of an identification.

#[cfg(feature = "experiments")]
pub mod commissioning;
mod comparison;
mod drift;
#[cfg(feature = "experiments")]
mod drive_status;
mod sweep;

#[cfg(feature = "experiments")]
pub use commissioning::{CommissioningEnd, CommissioningResult, DriveCommissioningResult};
pub use comparison::{CaseResult, ComparisonResult, Method, MethodErrors};
pub use drift::{Difference, DriftResult};
#[cfg(feature = "experiments")]
pub use drive_status::DriveStatus;
pub use sweep::{Distribution, Quantiles, Spread, SweepResult, SweepRun};
