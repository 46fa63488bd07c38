//! What the programs for the chip share: the paper's experiment, and how they speak through a
//! debugger or an emulator.
#![no_std]
#![deny(missing_docs)]

pub mod host;
pub mod instructions;
mod panic;
pub mod paper;
