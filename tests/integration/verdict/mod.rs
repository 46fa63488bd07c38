//! Reliability of the verdict and of the named causes, over many runs.

pub(crate) mod campaign;
mod effects;
mod gravity;
mod honesty;
mod logs;
mod misdeclared;
mod naming;
mod readings;
