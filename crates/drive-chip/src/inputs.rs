//! The amplifier's fault line and the switches. A broken wire of fault line or limit switch reads as a fault.

use crate::board::Board;
use crate::family::Bus;
use crate::pins::Input;
use crate::{pwm, supply};

/// The amplifier's fault line, the limit switches and the home switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inputs<B> {
    bus: B,
    fault: Input<B>,
    low_switch: Input<B>,
    high_switch: Input<B>,
    home_switch: Input<B>,
}

impl<B: Bus> Inputs<B> {
    pub(crate) fn new(bus: B, board: &Board<B::Family>) -> Self {
        Self {
            bus,
            fault: Input::new(bus, board.fault),
            low_switch: Input::new(bus, board.low_switch),
            high_switch: Input::new(bus, board.high_switch),
            home_switch: Input::new(bus, board.home_switch),
        }
    }

    /// True if the amplifier reports no fault, nor did it since the output was last disabled.
    #[inline]
    #[must_use]
    pub fn amplifier_is_healthy(&self) -> bool {
        self.fault.is_low() && !pwm::broke(self.bus)
    }

    /// True if the chip's supply has not sagged since the output was last disabled.
    #[inline]
    #[must_use]
    pub fn supply_is_healthy(&self) -> bool {
        supply::is_healthy(self.bus)
    }

    /// True for each limit switch that is closed: at the lower end, at the upper.
    #[inline]
    #[must_use]
    pub fn closed_switches(&self) -> [bool; 2] {
        [self.low_switch.is_low(), self.high_switch.is_low()]
    }

    /// True if the home switch is closed; an open wire is away from home.
    #[inline]
    #[must_use]
    pub fn home_switch_is_closed(&self) -> bool {
        self.home_switch.is_low()
    }
}
