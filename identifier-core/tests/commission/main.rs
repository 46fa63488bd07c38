//! Commissioning of simulated servos by the core alone.

mod machine;
mod rig;
