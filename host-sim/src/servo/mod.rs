//! The true servo: plant, encoder and amplifier, in SI and double precision.
//!
//! Written apart from the core's model on purpose: it is what the core is judged by.

mod encoder;
mod plant;

pub use encoder::Encoder;
pub use plant::Plant;
