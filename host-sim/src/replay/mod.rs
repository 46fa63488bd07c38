//! Recursive estimators on recorded logs. The recorded command drives their models.

#[cfg(feature = "experiments")]
mod online;
mod passes;

#[cfg(feature = "experiments")]
pub use online::OnlineIdentifier;
pub use passes::{Replayed, fitted, replay};
