//! Identification on a recorded log.
//!
//! A log is never in memory: [`log`] reads the file once to judge it, and each pass reads it again. The
//! passes drive the identifier's model with the command that was recorded; what the declared controller
//! would have commanded is held against it by [`agreement`]. A log without the command is driven by the
//! declared controller's, computed again.

pub mod agreement;
mod declared;
mod heard;
mod listener;
pub mod log;
mod passes;
mod recorded;
mod rows;
mod spacing;

pub use agreement::Agreement;
pub use log::Log;
pub use passes::{ReplayError, Replayed, fitted, replay};
pub use rows::{LogError, Record};
