//! The STM32F4's interrupts and their vectors, by the vendor's description.

pub(super) use drive_chip::F4 as Family;
pub use drive_chip::background::f4 as background;
pub use stm32f4xx_hal::pac::{Interrupt, interrupt};
