//! The frequency response that motions have measured, and the one or two masses that it shows.
//!
//! ```text
//! sums of motions ─► lines with deviations ─► one mass, two masses ─► resonance, or none
//! ```

mod measured_response;
mod model;
mod pass;
mod response_fit;
mod scan;
#[cfg(test)]
mod tests;

pub(super) use measured_response::{LineMeasurement, MeasuredResponse};
pub(super) use response_fit::{ResponseEstimate, ResponseFit};
