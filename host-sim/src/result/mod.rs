//! Results of experiments, serialised unchanged, beside those of an identification.

#[cfg(feature = "experiments")]
pub mod commissioning;
mod comparison;
mod sweep;

#[cfg(feature = "experiments")]
pub use commissioning::{CommissioningEnd, CommissioningOutcome, CommissioningResult, Untuned};
pub use comparison::{CaseResult, ComparisonResult, Method, MethodErrors};
pub use sweep::{Distribution, Quantiles, Spread, SweepResult, SweepRun};
