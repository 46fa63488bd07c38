//! The STM32G4's interrupts and their vectors, by the vendor's description.

pub(super) use drive_chip::G4 as Family;
pub use drive_chip::background::g4 as background;
pub use stm32g4::stm32g474::{Interrupt, interrupt};
