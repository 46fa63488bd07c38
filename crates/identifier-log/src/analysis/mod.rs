//! Conclusions from the samples of a log or a run.

mod assessment;
mod ending;
mod evidence;
mod rough;
mod seen;
mod sensor_noise;
mod statistics;
mod whole_record;

pub use assessment::{Assessment, Effort, VerifiedEstimate};
pub use ending::{Ending, EstimationMethod};
pub use rough::RoughAnswer;
pub use seen::{Braking, FoundResponse, FreeRun, Seen};
pub use statistics::Statistics;
pub(crate) use whole_record::WholeRecord;
