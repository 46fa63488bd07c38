//! The course of an estimator through an experiment, sample by sample.

mod estimate;
mod summary;
mod tail_buffer;

pub use summary::Summariser;
