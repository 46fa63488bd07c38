//! Shared parts of the programs for the chip.
//!
//! For the drive, one file of [`board`] assigns the pins to the drivers of `drive-chip`. A drive without a record
//! starts from [`settings`]. Beside them the paper's experiment and what speaks through an emulator.
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
mod panic;
pub mod paper;
pub mod settings;
