//! Provenance of a result, so that it can be reproduced.
//!
//! [`Origin`] is in every JSON result and in the description beside a CSV trace. It is read back from a result.

mod origin;

pub use origin::{LogFile, Origin, ScenarioText, Task, WithOrigin};
