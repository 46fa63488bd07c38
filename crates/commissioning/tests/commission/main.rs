//! Commissioning of simulated servos by this crate alone, and changes of servos that were commissioned.

mod continued_identification;
mod faults;
mod limits;
mod machine;
mod moving_axis;
mod noise;
mod rig;
mod servo_changes;
mod sound_axes;
mod suspected_fault;
mod two_mass_loop;
mod two_masses;
