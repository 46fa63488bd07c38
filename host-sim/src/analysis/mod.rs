//! Conclusions from the samples of an experiment; their presentation is in `present`.

mod assessment;
mod estimate;
mod evidence;
mod log_scan;
mod scaled_recording;
mod sensor_noise;
mod statistics;
mod stretch;
mod summary;
mod whole_record;

pub use crate::verdict::Status;
pub use log_scan::{remarks, scanned};
pub(crate) use sensor_noise::NoiseMeter;
pub use statistics::Statistics;
pub use summary::{FoundServo, Summariser};
