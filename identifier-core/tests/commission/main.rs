//! Commissioning of simulated servos by the core alone.

mod faults;
mod fit;
mod goes_on;
mod machine;
mod probing;
mod probing_support;
mod rig;
