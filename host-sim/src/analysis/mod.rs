//! Conclusions from the samples of an experiment; their presentation is in `present`.

mod assessment;
mod estimate;
mod evidence;
mod scaled_recording;
mod sensor_noise;
mod statistics;
mod stretch;
mod summary;
mod whole_record;

pub use crate::verdict::Status;
pub(crate) use sensor_noise::NoiseMeter;
pub use statistics::Statistics;
pub use summary::{FoundServo, Summariser};
