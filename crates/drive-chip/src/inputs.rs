//! The amplifier's fault line and the limit switches.

use crate::board::Board;
use crate::bus::Bus;
use crate::pins::Input;
use crate::pwm;

/// The amplifier's fault line and the limit switches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inputs<B> {
    bus: B,
    fault: Input<B>,
    low_switch: Input<B>,
    high_switch: Input<B>,
}

/// Their state: true is healthy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Healthy {
    /// The amplifier reports no fault, nor did it since the output was last disabled.
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
            fault: Input::new(bus, board.fault),
            low_switch: Input::new(bus, board.low_switch),
            high_switch: Input::new(bus, board.high_switch),
        }
    }

    /// Reads them.
    #[inline]
    #[must_use]
    pub fn read(&self) -> Healthy {
        Healthy {
            amplifier: self.fault.is_low() && !pwm::broke(self.bus),
            low_switch: self.low_switch.is_low(),
            high_switch: self.high_switch.is_low(),
        }
    }
}
