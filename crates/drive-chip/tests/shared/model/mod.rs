//! The parts of a model that every family shares.

pub(crate) mod block;
pub(crate) mod chip;
pub(crate) mod clocks;
pub(crate) mod memory;
pub(crate) mod pins;
pub(crate) mod timers;
pub(crate) mod usart;
pub(crate) mod watchdog;

use crate::model::supply;
