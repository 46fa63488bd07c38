//! Logs of messages: MCAP files whose channels are written in JSON.
//!
//! A column is a field of a topic, `servo.position` or `/joint_states.position[0]`, or the field alone where only
//! one topic has it. The topic of the position makes the samples; fields of other topics hold until they
//! are told anew.

mod field;
mod layout;
mod rows;

pub(super) use layout::Layout;
pub(super) use rows::MessageRows;
