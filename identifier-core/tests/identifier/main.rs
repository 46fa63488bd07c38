//! The laws over whole records: random servos, any controller, any input.

mod behind_amplifier;
mod chosen_gamma;
mod command_driven;
mod command_driven_robustness;
#[cfg(feature = "fixed")]
mod constants;
mod discretisation;
mod first_fit;
#[cfg(feature = "fixed")]
mod fixed_servo_loop;
mod gradient;
mod halves;
mod literal_loop;
#[cfg(feature = "fixed")]
mod memory;
mod refusals;
mod robustness;
mod shown_estimates;
mod support;
mod terms;
