//! Identifiers: a model and a law beside a servo that somebody keeps safe.
//!
//! All of them [`Identify`]: they are told how far the encoder moved and which command acts, and
//! nothing else. [`GradientIdentifier`] runs the paper's law ([`DiagonalGradientIdentifier`] for less
//! work in every sample). [`ServoLoop`] is our controller with one of them.

pub(crate) mod config;
mod error;
mod gradient;
mod identify;
mod servo_loop;

pub use error::IdentifierError;
pub use gradient::{
    DiagonalGradientIdentifier, GradientIdentifier, GradientIdentifierState, GradientIdentifierWith,
};
pub use identify::{Event, Identify, Seen};
pub use servo_loop::{LoopStep, ServoLoop, ServoLoopState};
