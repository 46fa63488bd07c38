//! What is concluded from the samples of an experiment; nothing here says how it is shown.

mod estimate;
pub mod residual;
mod statistics;
mod summary;
mod verdict;

pub use estimate::{Estimate, unit};
pub use statistics::Statistics;
pub use summary::{Summariser, Summary};
pub use verdict::Status;
