//! The STM32F401's interrupts and their vectors, by the vendor's description.

pub(super) use drive_chip::F401 as Family;
pub use drive_chip::background::f401 as background;
pub use stm32f4xx_hal::pac::{Interrupt, interrupt};
