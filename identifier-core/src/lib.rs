#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
#[macro_use]
extern crate std;

// Once, in SI: the settings that every part is built from, and the errors that name one.
pub mod constants;
pub mod error;
pub mod interval;
pub mod number;
pub mod parameters;
pub mod reason;
pub mod settings;
pub mod units;

// Listen: identify from counts and commands.
pub mod identifier;
pub mod measurement;

// Control.
pub mod control;
pub mod drive;
pub mod excitation;

// Tune.
pub mod tuning;

// Say how sure.
pub mod replay;
pub mod stability;

// The same in fixed point.
#[cfg(feature = "fixed")]
pub mod fixed_point;

// Parts of the above, of which a commissioning fits with two.
mod adaptation;
pub mod fit;
mod linalg;
pub mod model;
mod unrolled;

use identifier::{GradientIdentifier, ServoLoop};
use measurement::velocity::LowPass;

pub use settings::{ControllerSettings, Settings};

/// Our PID with a low-pass velocity estimate and the paper's identifier with a diagonal Γ.
pub type GradientLoop<N, S, const P: usize> =
    ServoLoop<N, LowPass<N>, GradientIdentifier<N, LowPass<N>, S, P>>;
