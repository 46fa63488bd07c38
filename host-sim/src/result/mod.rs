//! Results: of each experiment what was found, serialised as it is. Its fields are the keys of `--json`,
//! documented in docs/command-line.md; its numbers are what every page shows.

pub mod commissioning;
mod comparison;
mod drift;
mod experiment;
mod log;
mod sweep;
mod tuning;

pub use commissioning::CommissioningResult;
pub(crate) use comparison::error;
pub use comparison::{CaseResult, ComparisonResult, MethodErrors};
pub use drift::DriftResult;
pub use experiment::{
    Estimate, Estimates, OutputError, ReplayNotes, SettlingTime, Summary, TermSize,
};
pub use log::{LogReading, OpenLoopError, Prediction};
pub use sweep::SweepResult;
pub use tuning::{DelayedServo, FeedForward, Gains, StiffPromise, TuningConditions, TuningResult};
