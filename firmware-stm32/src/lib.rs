//! Shared parts of the programs for the chip.
//!
//! For the drive, one file of [`board`] assigns the pins to the drivers of `drive-chip`. A drive without a record
//! starts from [`settings`]. Beside them the paper's experiment, a servo on the chip, and what speaks through an emulator.
#![no_std]
#![deny(missing_docs)]
#![expect(
    missing_debug_implementations,
    reason = "peripherals have nothing to show"
)]

pub mod board;
#[cfg(feature = "emulator")]
pub mod emulated_servo;
pub mod ending;
pub mod hand_off;
pub mod host;
pub mod image;
pub mod instructions;
pub mod measured;
mod memory_test;
#[cfg(feature = "no-motor")]
pub mod no_motor;
mod panic;
pub mod paper;
#[cfg(any(feature = "emulator", feature = "no-motor"))]
pub mod servo_on_chip;
pub mod settings;
