//! Faults that begin while a servo runs, as a drive must find them.
//!
//! A caller that has a servo and faults calls three functions in each sample, in this order. They give the forces in it
//! ([`Faults::begin_sample`]), the reading of the encoder ([`Faults::seen`]), and the command that acts
//! ([`Faults::acting`]).

mod fault;
mod running;

pub use fault::{FaultKind, InjectedFault};
pub use running::{Condition, Faults};
