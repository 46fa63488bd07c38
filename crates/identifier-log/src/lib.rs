//! Identification of servos from recorded logs.

pub mod analysis;
pub mod experiment;
mod found_servo;
mod identify;
pub mod log;
mod motion_unit;
pub mod nearest;
pub mod physical;
pub mod predict;
pub mod provenance;
mod readings;
pub mod recognise;
pub mod replay;
pub mod result;
mod scaled_recording;
pub mod scenario;
pub mod tune;
pub mod verdict;

pub use found_servo::FoundServo;
pub use identify::{Identified, Recorded, identify, identify_run};
pub use motion_unit::{AxisKind, MotionUnit, UnstatedUnit};
