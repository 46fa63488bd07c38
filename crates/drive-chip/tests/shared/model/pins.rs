//! General-purpose pins (RM0090, 8).

use std::cell::{Cell, RefCell};
use std::collections::HashMap;

use super::block::Block;
use super::clocks::Peripheral;
use crate::facts::{PORTS_AFTER_RESET, port};
use crate::pac::{GPIOA, GPIOB, GPIOC};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Level {
    Low,
    High,
}

/// The line at a pin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Line {
    Open,
    Ground,
    Supply,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    Input,
    Output,
    Alternate(u8),
    Analog,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Pull {
    None,
    Up,
    Down,
}

pub(crate) struct Pins {
    ports: [Block<port::RegisterBlock>; 3],
    outside: RefCell<HashMap<(usize, usize), Line>>,
}

impl Pins {
    pub(crate) fn new() -> Self {
        let ports = [
            GPIOA::ptr().cast(),
            GPIOB::ptr().cast(),
            GPIOC::ptr().cast(),
        ]
        .map(Block::at);
        for (port, (mode, pull)) in ports.iter().zip(PORTS_AFTER_RESET) {
            let port: &Block<port::RegisterBlock> = port;
            port.set(port.moder(), mode);
            port.set(port.pupdr(), pull);
        }
        Self {
            ports,
            outside: RefCell::default(),
        }
    }

    pub(crate) fn outside(&self, port: usize, number: usize, line: Line) {
        self.outside.borrow_mut().insert((port, number), line);
    }

    pub(crate) fn mode(&self, port: usize, number: usize) -> Mode {
        let port = &self.ports[port];
        let mode = port.moder().read().moder(number as u8);
        if mode.is_input() {
            Mode::Input
        } else if mode.is_output() {
            Mode::Output
        } else if mode.is_analog() {
            Mode::Analog
        } else if number < 8 {
            Mode::Alternate(port.afrl().read().afr(number as u8).bits())
        } else {
            Mode::Alternate(port.afrh().read().afr(number as u8 - 8).bits())
        }
    }

    pub(crate) fn pull(&self, port: usize, number: usize) -> Pull {
        let pull = self.ports[port].pupdr().read().pupdr(number as u8);
        if pull.is_pull_up() {
            Pull::Up
        } else if pull.is_pull_down() {
            Pull::Down
        } else {
            Pull::None
        }
    }

    pub(crate) fn is_push_pull(&self, port: usize, number: usize) -> bool {
        self.ports[port]
            .otyper()
            .read()
            .ot(number as u8)
            .is_push_pull()
    }

    /// Makes a pin an open drain that is high, as an earlier program may have left it.
    pub(crate) fn leave_open_drain(&self, port: usize, number: usize) {
        let port = &self.ports[port];
        port.set(port.otyper(), port.get(port.otyper()) | 1 << number);
        port.set(port.odr(), port.get(port.odr()) | 1 << number);
    }

    /// Gives a pin function 15 and pulls it down, as an earlier program may have left it.
    pub(crate) fn leave_used(&self, port: usize, number: usize) {
        let port = &self.ports[port];
        let (low, high) = (port.get(port.afrl()), port.get(port.afrh()));
        if number < 8 {
            port.set(port.afrl(), low | 0xf << (4 * number));
        } else {
            port.set(port.afrh(), high | 0xf << (4 * (number - 8)));
        }
        let pulls = port.get(port.pupdr()) & !(0b11 << (2 * number));
        port.set(port.pupdr(), pulls | 0b10 << (2 * number));
    }

    /// The level of a pin that is an output.
    pub(crate) fn driven(&self, port: usize, number: usize) -> Level {
        if self.ports[port].odr().read().odr(number as u8).is_high() {
            Level::High
        } else {
            Level::Low
        }
    }

    /// The level on a pin. A floating one is low, which a broken wire must not be.
    pub(crate) fn level(&self, port: usize, number: usize) -> Level {
        if self.mode(port, number) == Mode::Output {
            return self.driven(port, number);
        }
        let outside = self.outside.borrow().get(&(port, number)).copied();
        match (outside, self.pull(port, number)) {
            (Some(Line::Ground), _) => Level::Low,
            (Some(Line::Supply), _) | (_, Pull::Up) => Level::High,
            _ => Level::Low,
        }
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let mut ports = self.ports.iter().enumerate();
        ports.find_map(|(number, port)| Some((Peripheral::Port(number), port.word(address)?)))
    }

    /// Reads a word of a port.
    pub(crate) fn read(&self, number: usize, address: u32, word: &Cell<u32>) -> u32 {
        let port = &self.ports[number];
        if address != port.address(port.idr()) {
            return word.get();
        }
        let high = |pin| self.level(number, pin) == Level::High;
        (0..16).map(|pin| u32::from(high(pin)) << pin).sum()
    }

    /// Writes a word of a port.
    pub(crate) fn write(&self, number: usize, address: u32, word: &Cell<u32>, new: u32) {
        let port = &self.ports[number];
        if address == port.address(port.bsrr()) {
            let high = port.get(port.odr()) & !(new >> 16) | new & 0xffff;
            port.set(port.odr(), high);
        } else {
            word.set(new);
        }
    }
}
