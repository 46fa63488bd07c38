//! USART2 (RM0090, 30).

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;

use stm32f4::stm32f405::{USART2, usart1};

use super::block::Block;
use super::clocks::{Clocks, Peripheral};

pub(crate) struct Usart {
    usart: Block<usart1::RegisterBlock>,
    /// Bytes that came and were not read yet.
    pub(crate) came: RefCell<VecDeque<u8>>,
    /// Bytes that were said.
    pub(crate) said: RefCell<Vec<u8>>,
    /// The byte being said is not out yet.
    pub(crate) busy: Cell<bool>,
    /// A byte came while the last one was not read.
    pub(crate) overrun: Cell<bool>,
    /// The status was read since.
    status_read: Cell<bool>,
}

impl Usart {
    pub(crate) fn new() -> Self {
        Self {
            usart: Block::at(USART2::ptr()),
            came: RefCell::default(),
            said: RefCell::default(),
            busy: Cell::new(false),
            overrun: Cell::new(false),
            status_read: Cell::new(false),
        }
    }

    pub(crate) fn reset(&self) {
        self.usart.clear();
    }

    /// Bits a second (30.3.4, equation 1).
    pub(crate) fn baud(&self, clocks: &Clocks) -> f64 {
        let divider = self.usart.brr().read();
        let over8 = self.usart.cr1().read().over8().is_oversample8();
        let samples = if over8 { 8.0 } else { 16.0 };
        let fraction = f64::from(divider.div_fraction().bits()) / samples;
        let factor = f64::from(divider.div_mantissa().bits()) + fraction;
        clocks.frequencies().low_bus / (samples * factor)
    }

    /// Whether it hears and says words of eight bits without parity.
    pub(crate) fn is_open(&self) -> bool {
        let control = self.usart.cr1().read();
        control.ue().is_enabled()
            && control.te().is_enabled()
            && control.re().is_enabled()
            && control.m().is_m8()
            && control.pce().is_disabled()
            && self.usart.get(self.usart.cr2()) == 0
    }

    /// Whether a byte that came interrupts.
    pub(crate) fn interrupts_for_hearing(&self) -> bool {
        self.usart.cr1().read().rxneie().is_enabled()
    }

    /// Whether room for a byte to be said interrupts.
    pub(crate) fn interrupts_for_saying(&self) -> bool {
        self.usart.cr1().read().txeie().is_enabled()
    }

    pub(crate) fn read(&self, address: u32, clocks: &Clocks) -> Option<u32> {
        let usart = &self.usart;
        let word = usart.word(address)?;
        if !clocks.is_on(Peripheral::Usart2) {
            return Some(0);
        }
        if address == usart.address(usart.sr()) {
            let bit = |there: bool, place: u32| u32::from(there) << place;
            self.status_read.set(true);
            word.set(
                bit(self.overrun.get(), 3)
                    | bit(!self.came.borrow().is_empty(), 5)
                    | bit(!self.busy.get(), 7),
            );
            let shown = usart.sr().read();
            assert_eq!(shown.ore().is_overrun(), self.overrun.get());
            assert_eq!(shown.txe().is_tx_empty(), !self.busy.get());
        } else if address == usart.address(usart.dr()) {
            if self.status_read.replace(false) {
                self.overrun.set(false);
            }
            return Some(self.came.borrow_mut().pop_front().unwrap_or(0).into());
        }
        Some(word.get())
    }

    pub(crate) fn write(&self, address: u32, word: u32, clocks: &Clocks) -> bool {
        let usart = &self.usart;
        let Some(place) = usart.word(address) else {
            return false;
        };
        if !clocks.reaches(Peripheral::Usart2) {
            return true;
        }
        if address == usart.address(usart.dr()) {
            assert!(!self.busy.get(), "the byte before is lost (30.3.2)");
            if self.is_open() {
                self.said.borrow_mut().push(word as u8);
            }
        } else {
            place.set(word);
        }
        true
    }
}
