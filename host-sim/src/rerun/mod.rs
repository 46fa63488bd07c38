//! What a result keeps of where it is from, so that it can be had again.
//!
//! [`Origin`] goes into every JSON result, MCAP file and the description beside a CSV trace; [`Kept`] is read
//! back from one of them, and says whether another run gave the same.

mod difference;
mod fingerprint;
mod kept;
mod origin;

pub use kept::{Kept, KeptError};
pub use origin::{LogFile, Origin, OriginAlone, ScenarioText, Task, WithOrigin};
