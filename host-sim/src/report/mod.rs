//! What is shown of an experiment: summary, table, CSV and pictures.

pub mod comparison;
pub mod csv;
pub mod distribution;
pub mod drift;
pub mod json;
pub mod panels;
pub mod plot;
pub mod residual;
mod statistics;
mod summary;
pub mod table;

pub use statistics::Statistics;
pub use summary::{Estimate, Status, Summariser, Summary, unit};
