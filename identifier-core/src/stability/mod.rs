//! Certificates of stability before the first sample.
//!
//! [`Certificate`] proves the continuous-time loop stable for a whole parameter range.
//! [`SampledLoop`] checks stability with sampling, hold and velocity filter.

mod characteristic;
mod hurwitz;
mod sampled_loop;

pub use crate::gradient::{Certificate, CertificateError, ParameterRange};
pub(crate) use sampled_loop::EstimateError;
pub use sampled_loop::{SampledLoop, SampledLoopError};
