//! The true servo: plant and encoder, in SI and double precision, on a PC and on the chip.
//!
//! Written apart from the core's model on purpose: it is the reference that the core is compared with. It
//! calls no platform's mathematics, so a run gives the same bits everywhere.
//!
//! [`Plant`] is the servo that the identifiers' model describes, in closed form. [`Servo`] has in
//! addition the effects of real servos, each of its [`Effects`] optional; without any it is a [`Plant`]. Its
//! failures in operation are in [`faults`].
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod brake;
mod effects;
mod encoder;
mod equation;
pub mod excitation;
pub mod faults;
mod friction;
mod front_end;
mod integrator;
mod motion;
mod noise;
mod plant;
mod sensor_errors;
mod servo;
mod wander;

pub use brake::VirtualBrake;
pub use effects::{EffectError, Effects};
pub use encoder::Encoder;
pub use identifier_core::parameters::ServoParameters;
pub use noise::{SplitMix64, distinct_seed};
pub use plant::Plant;
pub use sensor_errors::{SensorEffects, SensorErrors};
pub use servo::Servo;
