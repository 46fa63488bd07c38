//! Messages between a drive and its host over a serial line.
//!
//! A message is [postcard](https://postcard.jamesmunns.com) bytes and their CRC-32, framed by COBS. The CRC of a
//! report begins from another value than that of a request, so that the echo of a line is no request. No byte of a frame
//! is zero but its last, so a receiver that has lost bytes resumes at the next zero. No message is assumed to arrive.
//! Each [`Request`] carries a number that its answer repeats. An order, which may move the axis, has a number of its own,
//! by which it acts once. Telemetry without room is dropped and counted. The [`Record`] that a drive keeps is postcard
//! bytes too.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod commissioning;
mod frame;
mod guidance;
mod line;
mod message;
mod motion_record;
mod record;
mod settings;
mod term_sizes;

pub use commissioning::{Commissioning, Gains, NoGains, Origin, Outcome, Progress};
pub use frame::{
    FrameError, MAX_FRAME_BYTES, MAX_MESSAGE_BYTES, Message, Receiver, StopListener, frame,
};
pub use guidance::{Home, Homing, TargetSource};
pub use line::Line;
pub use message::{
    BoardTest, BootChecks, Command, Cycles, Ended, Estimates, Fault, InterruptCycles, Kept,
    Noticed, PROTOCOL, Refusal, Report, Request, Snapshot, State, Status,
};
pub use motion_record::MotionRecord;
pub use record::{Commissioned, Record};
pub use settings::{
    Dither, Estimator, HoldingBrake, LoopSettings, Name, NotAllowed, Protection, ServoChanges,
    Settings, Why,
};
pub use term_sizes::TermSizes;
