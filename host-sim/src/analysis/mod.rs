//! The course of an estimator through an experiment, sample by sample.

mod estimate;
mod summary;

pub use summary::Summariser;
