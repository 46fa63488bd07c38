//! The lines that must be healthy.

use crate::board::Board;
use crate::bus::Bus;
use crate::pins::Pin;
use crate::pwm;

/// The amplifier's fault line and the limit switches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inputs<B> {
    bus: B,
    fault: Pin,
    low_switch: Pin,
    high_switch: Pin,
}

/// Which of them are healthy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Healthy {
    /// The amplifier reports no fault, nor did it since the output was last let go.
    pub amplifier: bool,
    /// The limit switch at the lower end is closed.
    pub low_switch: bool,
    /// The limit switch at the upper end is closed.
    pub high_switch: bool,
}

impl<B: Bus> Inputs<B> {
    pub(crate) fn new(bus: B, board: &Board) -> Self {
        Self {
            bus,
            fault: board.fault,
            low_switch: board.low_switch,
            high_switch: board.high_switch,
        }
    }

    /// What they say now.
    #[inline]
    #[must_use]
    pub fn read(&self) -> Healthy {
        let bus = self.bus;
        Healthy {
            amplifier: self.fault.is_low(bus) && !pwm::broke(bus),
            low_switch: self.low_switch.is_low(bus),
            high_switch: self.high_switch.is_low(bus),
        }
    }
}
