//! Identifiers beside a running controller.
//!
//! [`GradientIdentifier`] runs the paper's law ([`DiagonalGradientIdentifier`] for less work in every
//! sample). [`GaussNewtonIdentifier`], the fast one with standard errors, and [`WindowIdentifier`],
//! which fits the last samples again and again in the background, only listen ([`Identify`]): they
//! need no controller, and no first guess.

mod config;
mod error;
mod fit;
mod gauss_newton;
mod gradient;
mod identify;
mod settings;
mod window;

pub use config::{Bounds, IdentifierConfig};
pub use error::IdentifierError;
pub use fit::{Block, Blocking, Record};
pub use gauss_newton::{GaussNewtonIdentifier, GaussNewtonIdentifierState, Start};
pub use gradient::{
    DiagonalGradientIdentifier, GradientIdentification, GradientIdentifier,
    GradientIdentifierState, GradientIdentifierWith, GradientLaw,
};
pub use identify::{Event, Identify, Seen};
pub use settings::{Knowledge, ListeningSettings};
pub use window::{WindowIdentifier, WindowState};
