//! A model of the STM32G474's registers and of their effects on a drive.

pub(crate) mod clocks;
pub(crate) mod memory;
pub(crate) mod supply;
pub(crate) mod usart;

use crate::shared::model::{block, chip, pins, timers};

pub(crate) use crate::shared::model::clocks::Source;
pub(crate) use chip::Chip;
pub(crate) use pins::{Level, Line, Mode, Pull};
pub(crate) use timers::Output;
