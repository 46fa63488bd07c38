//! Identifiers: a model loop and a law beside a running controller.
//!
//! [`GradientIdentifier`] runs the paper's law ([`DiagonalGradientIdentifier`] for less work in every
//! sample), [`GaussNewtonIdentifier`] the fast one with standard errors, [`WindowIdentifier`] fits the
//! last samples again and again in the background. All are built from the same [`IdentifierConfig`]
//! and a configuration of the law, and take each sample after the controller's.

mod config;
mod error;
mod gauss_newton;
mod gradient;
mod window;

pub use config::{Bounds, IdentifierConfig};
pub use error::IdentifierError;
pub use gauss_newton::{
    GaussNewtonIdentification, GaussNewtonIdentifier, GaussNewtonIdentifierState, Uncertainty,
};
pub use gradient::{
    DiagonalGradientIdentifier, GradientIdentification, GradientIdentifier,
    GradientIdentifierState, GradientIdentifierWith, GradientLaw,
};
pub use window::{Found, Recorded, Window, WindowIdentifier, WindowState};
