#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod cause;
pub mod fit;
mod identify;
pub mod parallel;
mod scales;

pub use cause::Cause;
pub use fit::GoesOn;
pub use identify::{
    Axis, Between, Course, Entered, Estimated, Examined, FreeRun, Identified, Lacking, Logged,
    MAX_SAMPLES, ModelDemand, Recording, SEPARATED, SecondMode, Way, effects, examine, free_run,
    identify,
};
pub use scales::{Predicted, TimeScale, predicted, scales_of, surest};
