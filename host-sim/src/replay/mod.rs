//! Recursive estimators on recorded logs. The recorded command drives their models.

mod identify;
#[cfg(feature = "experiments")]
mod online;
mod passes;
mod recorded;

pub use identify::identify;
#[cfg(feature = "experiments")]
pub use online::OnlineIdentifier;
pub use passes::{Replayed, fitted, replay};
