//! Commissioning of simulated servos by the core alone.

mod faults;
mod fit;
mod goes_on;
mod machine;
mod rig;
mod wiggle;
mod wiggle_support;
