//! The drivers against a model of an STM32F405.

mod facts;
mod flash;
mod model;
mod option_bytes;
#[path = "../shared/mod.rs"]
mod shared;

use shared::{BOARD, healthy, memory, slow, wired};
use stm32f4::stm32f405 as pac;

/// The family.
pub(crate) type Family = drive_chip::F4;
