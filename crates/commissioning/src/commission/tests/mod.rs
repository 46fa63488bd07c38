//! The parts of a commissioning on simulated servos: the first motion, the fit to it, its prediction and its
//! diagnosis.

mod fit;
mod probing;
pub(crate) mod unknown_servos;
