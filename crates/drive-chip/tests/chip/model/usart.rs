//! USART2 (RM0090, 30).

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;

use stm32f4::stm32f405::{USART2, usart1};

use super::block::Block;
use super::clocks::{Clocks, Peripheral};

pub(crate) struct Usart {
    usart: Block<usart1::RegisterBlock>,
    /// Received bytes that were not read yet.
    pub(crate) received: RefCell<VecDeque<u8>>,
    /// Sent bytes.
    pub(crate) sent: RefCell<Vec<u8>>,
    /// A byte is being sent.
    pub(crate) busy: Cell<bool>,
    /// A byte was received while the last one was not read.
    pub(crate) overrun: Cell<bool>,
    /// The status was read since.
    status_read: Cell<bool>,
}

impl Usart {
    pub(crate) fn new() -> Self {
        Self {
            usart: Block::at(USART2::ptr()),
            received: RefCell::default(),
            sent: RefCell::default(),
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

    /// True if it receives and sends words of eight bits without parity.
    pub(crate) fn is_open(&self) -> bool {
        let control = self.usart.cr1().read();
        control.ue().is_enabled()
            && control.te().is_enabled()
            && control.re().is_enabled()
            && control.m().is_m8()
            && control.pce().is_disabled()
            && self.usart.get(self.usart.cr2()) == 0
    }

    /// True if a received byte interrupts.
    pub(crate) fn interrupts_on_reception(&self) -> bool {
        self.usart.cr1().read().rxneie().is_enabled()
    }

    /// True if it interrupts when a byte can be sent.
    pub(crate) fn interrupts_for_sending(&self) -> bool {
        self.usart.cr1().read().txeie().is_enabled()
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        Some((Peripheral::Usart2, self.usart.word(address)?))
    }

    /// Reads a word of it.
    pub(crate) fn read(&self, address: u32, word: &Cell<u32>) -> u32 {
        let usart = &self.usart;
        if address == usart.address(usart.sr()) {
            let bit = |there: bool, place: u32| u32::from(there) << place;
            self.status_read.set(true);
            word.set(
                bit(self.overrun.get(), 3)
                    | bit(!self.received.borrow().is_empty(), 5)
                    | bit(!self.busy.get(), 7),
            );
            let shown = usart.sr().read();
            assert_eq!(shown.ore().is_overrun(), self.overrun.get());
            assert_eq!(shown.txe().is_tx_empty(), !self.busy.get());
        } else if address == usart.address(usart.dr()) {
            if self.status_read.replace(false) {
                self.overrun.set(false);
            }
            return self.received.borrow_mut().pop_front().unwrap_or(0).into();
        }
        word.get()
    }

    /// Writes a word of it.
    pub(crate) fn write(&self, address: u32, word: &Cell<u32>, new: u32) {
        let usart = &self.usart;
        if address == usart.address(usart.dr()) {
            assert!(!self.busy.get(), "the byte before is lost (30.3.2)");
            if self.is_open() {
                self.sent.borrow_mut().push(new as u8);
            }
        } else {
            word.set(new);
        }
    }
}
