//! Identification on a recorded log.
//!
//! A log is never in memory: [`log`] reads the file once to judge it, and each pass reads it again:
//! `text` unpacks it, `dialect` finds out how it is written, `rows` makes samples in SI of it (`messages` of an
//! MCAP file), and `spacing` puts them in even time. Where something is left out, and where a log ends, a stretch
//! ends: nothing is carried over such a break but the estimates.
//!
//! The passes drive the identifier's model with the command that was recorded; what the declared controller
//! would have commanded is held against it by [`agreement`]. A log without the command is driven by the
//! declared controller's, computed again.

pub mod agreement;
mod cell;
mod clock;
mod columns;
mod declared;
mod dialect;
mod error;
mod heard;
mod listener;
pub mod log;
mod messages;
mod passes;
mod predict;
mod progress;
mod recorded;
mod rows;
mod source;
mod spacing;
mod text;

pub use agreement::Agreement;
pub use clock::Jitter;
pub use error::LogError;
pub use log::{Found, Log};
pub use passes::{ReplayError, Replayed, fitted, replay};
pub use predict::{Predicted, predict};
pub use rows::Record;
