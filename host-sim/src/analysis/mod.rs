//! Conclusions from the samples of an experiment.

mod assessment;
mod closed_loop;
mod estimate;
mod evidence;
mod information;
mod reachable;
mod scales;
mod seen;
mod sensor_noise;
mod statistics;
mod summary;
mod tail_buffer;
mod whole_record;

pub use identifier_log::verdict::Status;
pub use closed_loop::{LoopFigures, Response};
pub use seen::{Braking, FoundResponse, Seen};
pub use statistics::Statistics;
pub use summary::Summariser;
