//! The true servo: plant and encoder, in SI and double precision, on a PC and on the chip.
//!
//! Written apart from the core's model on purpose: it is what the core is judged by. It calls no
//! platform's mathematics, so one run gives the same bits wherever it runs.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod encoder;
mod plant;

pub use encoder::Encoder;
pub use plant::Plant;
