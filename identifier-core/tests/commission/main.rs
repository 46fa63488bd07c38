//! Commissioning of simulated servos by the core alone.

mod continued_identification;
mod faults;
mod fit;
mod machine;
mod probing;
mod probing_support;
mod rig;
