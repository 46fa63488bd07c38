//! Certificates of stability before the first sample.
//!
//! [`Certificate`] proves the continuous-time loop stable for a whole parameter range.
//! [`SampledLoop`] checks stability with sampling, hold and velocity filter.

mod certificate;
mod characteristic;
mod hurwitz;
mod parameter_range;
mod sampled_loop;

pub(crate) use certificate::automatic_mu;
pub use certificate::{Certificate, CertificateError};
pub use parameter_range::ParameterRange;
pub use sampled_loop::{EstimateError, SampledLoop, SampledLoopError};

use crate::constants::encode;

/// The results of the stability checks over the parameter range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StabilityCheck {
    pub(crate) certificate: Certificate,
    pub(crate) gain_margin: f64,
}

encode! {
    [] StabilityCheck as "StabilityCheck" { certificate, gain_margin }
}
