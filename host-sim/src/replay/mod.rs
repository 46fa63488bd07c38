//! Identification on a recorded log with a declared controller.
//!
//! [`log`] reads and judges the file, [`agreement`] holds the recorded command against the declared
//! controller, and the passes run the same controller and identifier over the log as a drive would
//! have.

pub mod agreement;
pub mod log;
mod passes;
mod recorded;

pub use agreement::Agreement;
pub use log::{Log, LogError};
pub use passes::{ReplayError, Replayed, replay};
