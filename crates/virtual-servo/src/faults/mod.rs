//! Faults that begin while a servo runs, as a drive must find them.
//!
//! A caller that has a servo and faults asks, in each sample and in this order, what holds in it
//! ([`Faults::begin_sample`]), what the encoder shows ([`Faults::seen`]), and which command acts
//! ([`Faults::acting`]).

mod fault;
mod running;

pub use fault::{FaultKind, InjectedFault};
pub use running::{Condition, Faults};
