//! The drivers against a model of an STM32G474.

mod facts;
mod flash;
mod model;
mod option_bytes;
mod over_current;
#[path = "../shared/mod.rs"]
mod shared;

use shared::{BOARD, healthy, memory, slow, wired};
use stm32g4::stm32g474 as pac;

/// The family.
pub(crate) type Family = drive_chip::G4;
