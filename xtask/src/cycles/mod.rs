//! The cost of an interrupt handler on a Cortex-M4F: instructions as they are executed, and cycles by the model of
//! `docs/cycles.md`.

mod flash;
mod meter;
mod processor;

pub(crate) use meter::{Cost, Lost, Meter, OutputWords, Taken, Watched};
pub(crate) use processor::Choice;
