//! Identification on a recorded log.
//!
//! [`log`] reads and judges the file, and the passes drive the identifier's model with the command
//! that was recorded; what the declared controller would have commanded is held against it by
//! [`agreement`]. A log without the command is driven by the declared controller's, computed again.

pub mod agreement;
pub mod log;
mod passes;
mod recorded;

pub use agreement::Agreement;
pub use log::{Log, LogError};
pub use passes::{ReplayError, Replayed, fitted, replay};
