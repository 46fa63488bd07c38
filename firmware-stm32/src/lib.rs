//! What the programs for the chip share.
//!
//! For the drive: one file of [`board`] says which pin is what; [`clock`], [`serial`], [`timer`],
//! [`pwm`], [`quadrature`] and [`internal_flash`] are the chip's peripherals; [`settings`] is what a
//! drive without a record starts from. Beside them the paper's experiment and what speaks through an
//! emulator.
#![no_std]
#![deny(missing_docs)]
#![expect(
    missing_debug_implementations,
    reason = "peripherals have nothing to show"
)]

pub mod board;
pub mod clock;
pub mod handed;
pub mod host;
pub mod instructions;
pub mod internal_flash;
mod panic;
pub mod paper;
pub mod pwm;
pub mod quadrature;
pub mod serial;
pub mod settings;
pub mod timer;
