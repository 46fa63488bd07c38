//! Results: of each experiment what was found, serialised as it is. Its fields are the keys of `--json`,
//! documented in docs/command-line.md; its numbers are what every page shows.

mod experiment;
mod log;

pub use experiment::{
    Estimate, Estimates, OutputError, ReplayNotes, SettlingTime, Summary, TermSize,
};
pub use log::{LogReading, OpenLoopError, Prediction};
