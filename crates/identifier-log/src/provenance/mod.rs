//! The origin of a result: version, command line, scenario and logs, whole in every result.

#[cfg(feature = "files")]
mod fingerprint;
mod origin;

pub use origin::{LogFile, Origin, ScenarioText, Task, WithOrigin};
