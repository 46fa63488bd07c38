//! Provenance of a result, so that it can be reproduced.
//!
//! [`Origin`] is in every JSON result and in the description beside a CSV trace. [`Kept`] is read back from one of them
//! and compared with the result of another run.

mod difference;
mod fingerprint;
mod kept;
mod origin;

pub use kept::{Kept, KeptError};
pub use origin::{LogFile, Origin, ScenarioText, Task, WithOrigin};
