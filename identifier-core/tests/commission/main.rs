//! Commissioning of simulated servos by the core alone.

mod continued_identification;
mod faults;
mod machine;
mod noise;
mod rig;
mod suspected;
mod two_mass_loop;
mod two_masses;
