//! MCAP files, as Foxglove, PlotJuggler and ROS tools show them.
//!
//! Messages are JSON with a JSON schema: flat channels of numbers, SI, and joint states. Only a part of a file
//! is ever in memory: [`Recorder`] writes sample by sample, and [`Records`] reads record by record.
//! [`trace`] and [`commissioning`] name the channels of a run and of a commissioning.
//!
//! As a log to replay, a column is a field of a topic, `servo.position` or `/joint_states.position[0]`, or the
//! field alone where only one topic has it. The topic of the position makes the samples; fields of other topics
//! hold until their next message.

pub mod channel;
pub mod commissioning;
mod layout;
mod recorder;
mod records;
mod rows;
pub mod trace;

pub use channel::Channel;
pub(super) use layout::Layout;
pub use recorder::Recorder;
pub use records::{Damage, McapRecord, Records, is_mcap};
pub(super) use rows::MessageRows;
