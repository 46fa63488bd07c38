//! What can be certified before the first sample.
//!
//! [`certificate`] proves the continuous-time loop stable for a whole box of servos;
//! [`sampled_loop`] checks what sampling, hold and velocity filter leave of it.

pub mod certificate;
mod characteristic;
mod hurwitz;
mod plant_box;
pub mod sampled_loop;

pub use certificate::{Certificate, CertificateError};
pub use plant_box::PlantBox;

/// The results of the stability checks over the box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StabilityCheck {
    pub(crate) certificate: Certificate,
    pub(crate) gain_margin: f64,
}
