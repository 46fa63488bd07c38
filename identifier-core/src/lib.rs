#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
#[macro_use]
extern crate std;

mod adaptation;
pub mod commission;
pub mod control;
pub mod drive;
pub mod error;
pub mod excitation;
mod fit;
#[cfg(feature = "fixed")]
pub mod fixed_point;
pub mod identifier;
pub mod interval;
mod linalg;
pub mod measurement;
mod model;
pub mod number;
pub mod parameters;
mod reason;
pub mod replay;
pub mod settings;
pub mod stability;
pub mod tuning;
pub mod units;
mod watch;

use identifier::{DiagonalGradientIdentifier, ServoLoop};
use measurement::velocity::LowPass;

pub use settings::{ControllerSettings, Settings};

/// Our PID with a low-pass velocity estimate and the paper's identifier with a diagonal Γ.
pub type GradientLoop<N, S, const P: usize> =
    ServoLoop<N, LowPass<N>, DiagonalGradientIdentifier<N, LowPass<N>, S, P>>;
