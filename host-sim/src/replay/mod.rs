//! Identification on recorded logs.
//!
//! The passes drive the identifier's model with the recorded command. [`agreement`] compares the command of the
//! declared controller with it. A log without the command is driven by the declared controller's, computed again.

pub mod agreement;
mod declared;
#[cfg(feature = "experiments")]
mod online;
mod passes;
mod progress;
mod recorded;
mod scaled;
mod settling;

pub use agreement::Agreement;
pub(crate) use declared::DeclaredPid;
#[cfg(feature = "experiments")]
pub use online::OnlineIdentifier;
pub use passes::{Replayed, fitted, replay};
