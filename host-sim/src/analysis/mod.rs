//! The course of an estimator through an experiment, sample by sample.

mod closed_loop;
mod estimate;
mod summary;
mod tail_buffer;

pub use closed_loop::{LoopFigures, Response};
pub use summary::Summariser;
