//! What is concluded from the samples of an experiment; nothing here says how it is shown.

mod batch;
mod estimate;
mod evidence;
mod statistics;
mod stretch;
mod summary;

pub use crate::verdict::Status;
pub use statistics::Statistics;
pub use summary::Summariser;
