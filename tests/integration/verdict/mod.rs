//! Reliability of the verdict and of the named causes, over many runs.

mod between_rows;
pub(crate) mod campaign;
mod cogging;
mod effects;
mod gravity;
mod honesty;
mod logs;
mod misdeclared;
mod naming;
mod readings;
mod stranger;
