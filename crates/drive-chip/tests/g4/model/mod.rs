//! A model of the STM32G474's registers and of their effects on a drive.

mod adc;
#[path = "../../shared/model/block.rs"]
mod block;
#[path = "../../shared/model/chip.rs"]
mod chip;
mod clocks;
mod memory;
#[path = "../../shared/model/pins.rs"]
mod pins;
mod supply;
#[path = "../../shared/model/timers.rs"]
mod timers;
mod usart;
#[path = "../../shared/model/watchdog.rs"]
mod watchdog;

pub(crate) use chip::Chip;
pub(crate) use clocks::Source;
pub(crate) use pins::{Level, Line, Mode, Pull};
pub(crate) use timers::Output;
