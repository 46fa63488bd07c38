//! General-purpose pins (RM0090, 8).

use std::cell::RefCell;
use std::collections::HashMap;

use stm32f4::stm32f405::{GPIOA, GPIOB, GPIOC, gpioi};

use super::block::Block;
use super::clocks::{Clocks, Peripheral};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Level {
    Low,
    High,
}

/// What drives a pin from outside.
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
    ports: [Block<gpioi::RegisterBlock>; 3],
    outside: RefCell<HashMap<(usize, usize), Line>>,
}

impl Pins {
    pub(crate) fn new() -> Self {
        let ports = [GPIOA::ptr().cast(), GPIOB::ptr().cast(), GPIOC::ptr()].map(Block::at);
        // The debugger's pins (8.4.1 and 8.4.4).
        for (port, mode, pull) in [(0, 0xa800_0000, 0x6400_0000), (1, 0x280, 0x100)] {
            let port: &Block<gpioi::RegisterBlock> = &ports[port];
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

    /// Makes a pin an open drain that is high, as a program before may have left it.
    pub(crate) fn leave_open_drain(&self, port: usize, number: usize) {
        let port = &self.ports[port];
        port.set(port.otyper(), port.get(port.otyper()) | 1 << number);
        port.set(port.odr(), port.get(port.odr()) | 1 << number);
    }

    /// Gives a pin function 15 and pulls it down, as a program before may have left it.
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

    /// What a pin that is an output drives.
    pub(crate) fn driven(&self, port: usize, number: usize) -> Level {
        if self.ports[port].odr().read().odr(number as u8).is_high() {
            Level::High
        } else {
            Level::Low
        }
    }

    /// What is on the pin. One that floats is low, which is what a broken wire must not be.
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

    fn find(&self, address: u32) -> Option<(usize, &Block<gpioi::RegisterBlock>)> {
        let mut ports = self.ports.iter().enumerate();
        ports.find(|(_, port)| port.word(address).is_some())
    }

    pub(crate) fn read(&self, address: u32, clocks: &Clocks) -> Option<u32> {
        let (number, port) = self.find(address)?;
        if !clocks.is_on(Peripheral::Port(number)) {
            return Some(0);
        }
        if address == port.address(port.idr()) {
            let levels =
                (0..16).map(|pin| u32::from(self.level(number, pin) == Level::High) << pin);
            return Some(levels.sum());
        }
        port.word(address).map(|word| word.get())
    }

    pub(crate) fn write(&self, address: u32, word: u32, clocks: &Clocks) -> bool {
        let Some((number, port)) = self.find(address) else {
            return false;
        };
        if !clocks.reaches(Peripheral::Port(number)) {
            return true;
        }
        if address == port.address(port.bsrr()) {
            let high = port.get(port.odr()) & !(word >> 16) | word & 0xffff;
            port.set(port.odr(), high);
        } else if let Some(place) = port.word(address) {
            place.set(word);
        }
        true
    }
}
