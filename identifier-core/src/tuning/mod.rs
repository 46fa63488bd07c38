//! Gains from what was identified, and what they promise.

mod goal;
mod promise;
mod settings;

pub use goal::{Cap, Goal};
pub use promise::{Promise, Tuning};
pub use settings::{TuningError, TuningSettings};
