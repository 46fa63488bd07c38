#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod adaptation;
pub mod commission;
pub mod control;
pub mod drive;
pub mod error;
pub mod excitation;
pub(crate) mod fit;
#[cfg(feature = "fixed")]
pub mod fixed_point;
pub mod identifier;
pub mod interval;
pub mod linalg;
pub mod measurement;
pub mod model;
pub mod number;
pub mod parameters;
pub mod reason;
pub mod settings;
pub mod stability;
pub mod tuning;
pub mod units;
pub mod watch;

use identifier::{DiagonalGradientIdentifier, ServoLoop};
use measurement::velocity::LowPass;

pub use settings::{ControllerSettings, Settings};

/// Our PID with a low-pass velocity estimate and the paper's identifier with a diagonal Γ.
pub type GradientLoop<N, S, const P: usize> =
    ServoLoop<N, LowPass<N>, DiagonalGradientIdentifier<N, LowPass<N>, S, P>>;
