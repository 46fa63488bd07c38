//! Results: the findings of an identification, serialised unchanged. Its fields are the keys of `--json`, documented in
//! docs/results.md; its numbers are what every page shows.

mod experiment;
mod finding;
mod fit;
mod form;
mod kept;
mod log;
mod tuning;

pub use crate::column_reading::{ColumnReading, CommandReading, CommandSign, Reading};
pub use experiment::{
    Covariance, Estimate, Estimates, OutputError, ReplayNotes, SensorNoise, SettlingTime, Summary,
    TermSize, serialize_reason,
};
pub use finding::Finding;
pub use fit::{BrakingForce, EnteredEffect, FitNotes, ScaleEstimate, SecondMode};
pub use form::{FormMargins, FormParameter, FormResult, FormStep};
pub use kept::{
    KeptCovariance, KeptEffect, KeptEstimate, KeptFit, KeptLog, KeptResidual, KeptResult, NoResult,
};
pub use log::{LogReading, OpenLoopError, Prediction};
pub use tuning::{
    DelayedServo, FeedForward, FirstTrial, FoundMode, Gains, KnownForces, StiffPrediction,
    TuningConditions, TuningResult,
};
