//! Logs that others read: MCAP files, as Foxglove, PlotJuggler and ROS tools show them.
//!
//! Messages are JSON with a JSON schema: flat channels of numbers, SI, and joint states. Nothing is ever in
//! memory but a part: [`Recorder`] writes sample by sample, and [`Records`] reads record by record.
//!
//! [`trace`] and [`commissioning`] say which channels a run and a commissioning have.

pub mod channel;
pub mod commissioning;
mod reader;
mod recorder;
pub mod trace;

pub use channel::Channel;
pub use reader::{Damage, Record, Records, is_mcap};
pub use recorder::Recorder;
