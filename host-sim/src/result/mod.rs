//! Results: the findings of each experiment, serialised unchanged. Its fields are the keys of `--json`, documented in
//! docs/results.md; its numbers are what every page shows.

#[cfg(feature = "experiments")]
pub mod commissioning;
mod comparison;
mod drift;
#[cfg(feature = "experiments")]
mod drive_status;
mod experiment;
mod fit;
mod form;
#[cfg(feature = "experiments")]
mod kept;
mod log;
mod reason;
mod residual;
mod sensor_noise;
mod sweep;
mod tuning;

#[cfg(feature = "experiments")]
pub use commissioning::{CommissioningEnd, CommissioningResult, DriveCommissioningResult};
pub use comparison::{CaseResult, ComparisonResult, Method, MethodErrors};
pub use drift::{Difference, DriftResult};
#[cfg(feature = "experiments")]
pub use drive_status::DriveStatus;
pub use experiment::{
    Covariance, Estimate, Estimates, OutputError, ReplayNotes, SettlingTime, Summary, TermSize,
};
pub use fit::{BrakingForce, EnteredEffect, FitNotes};
pub use form::{FormMargins, FormParameter, FormResult, FormStep};
#[cfg(feature = "experiments")]
pub use kept::{
    KeptCovariance, KeptEstimate, KeptLog, KeptNoise, KeptResidual, KeptResult, NoResult,
};
pub use log::{LogReading, OpenLoopError, Prediction};
pub use residual::{Finding, Residual};
pub use sensor_noise::SensorNoise;
pub use sweep::{Distribution, Quantiles, Spread, SweepResult, SweepRun};
pub use tuning::{
    DelayedServo, FeedForward, Gains, KnownForces, StiffPrediction, TuningConditions, TuningResult,
};
