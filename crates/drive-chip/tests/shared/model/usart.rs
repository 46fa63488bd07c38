//! USART2 and the DMA of its reception: what both families have (RM0090, 30 and 10; RM0440, USART and DMA).

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicU8, Ordering};

use drive_chip::serial::Ring;

use super::block::Block;
use crate::model::clocks::Peripheral;
use crate::model::usart::{CLEARS_BY_READING, Dma, FLAGS, Own};
use crate::pac::{DMA1, USART2, usart1};

pub(crate) struct Usart {
    pub(crate) usart: Block<usart1::RegisterBlock>,
    pub(crate) dma: Block<Dma>,
    pub(crate) own: Own,
    /// Memory that the DMA reaches.
    memory: Cell<Option<&'static Ring>>,
    /// Length of the transfer as it was written, for the next round.
    length: Cell<u32>,
    /// A received byte that was not read yet.
    pub(crate) received: Cell<Option<u8>>,
    /// Sent bytes.
    pub(crate) sent: RefCell<Vec<u8>>,
    /// A byte is being sent.
    pub(crate) busy: Cell<bool>,
    /// A byte was received while the last one was not read.
    pub(crate) overrun: Cell<bool>,
    /// A byte without a stop bit was received, as a break is.
    pub(crate) framing_error: Cell<bool>,
    /// The status was read since.
    status_read: Cell<bool>,
}

/// Addresses of registers.
pub(crate) struct Places {
    pub(crate) status: u32,
    pub(crate) received: u32,
    pub(crate) sent: u32,
    /// The DMA's flags and control, the bytes that are left, the peripheral and the memory.
    pub(crate) flags: u32,
    pub(crate) control: u32,
    pub(crate) left: u32,
    pub(crate) peripheral: u32,
    pub(crate) memory: u32,
}

/// What the DMA flags, as places in a list of flags.
const HALF: usize = 0;
const WHOLE: usize = 1;
const ERROR: usize = 2;

impl Usart {
    pub(crate) fn new() -> Self {
        Self {
            usart: Block::at(USART2::ptr()),
            dma: Block::at(DMA1::ptr()),
            own: Own::default(),
            memory: Cell::new(None),
            length: Cell::new(0),
            received: Cell::new(None),
            sent: RefCell::default(),
            busy: Cell::new(false),
            overrun: Cell::new(false),
            framing_error: Cell::new(false),
            status_read: Cell::new(false),
        }
    }

    pub(crate) fn reset(&self) {
        self.usart.clear();
    }

    pub(crate) fn reset_dma(&self) {
        self.dma.clear();
        self.own.clear();
    }

    /// Lets the DMA reach a ring.
    pub(crate) fn reach(&self, ring: &'static Ring) {
        self.memory.set(Some(ring));
    }

    /// True if it receives and sends words of eight bits without parity.
    pub(crate) fn is_open(&self) -> bool {
        let control = self.usart.cr1().read();
        control.ue().bit()
            && control.te().bit()
            && control.re().bit()
            && !control.pce().bit()
            && self.has_eight_bits()
            && self.usart.get(self.usart.cr2()) == 0
    }

    /// True if a received byte interrupts.
    pub(crate) fn interrupts_on_reception(&self) -> bool {
        self.usart.get(self.usart.cr1()) & 1 << 5 != 0
    }

    /// True if it interrupts when a byte can be sent.
    pub(crate) fn interrupts_for_sending(&self) -> bool {
        self.usart.get(self.usart.cr1()) & 1 << 7 != 0
    }

    /// Receives a byte. Where the DMA does not take it, it stands in the data register, and the next one is lost.
    pub(crate) fn receive(&self, byte: u8) {
        if !self.is_open() {
            return;
        }
        if self.received.get().is_some() {
            self.overrun.set(true);
            return;
        }
        self.received.set(Some(byte));
        if self.usart.cr3().read().dmar().bit() && self.takes_received_bytes() {
            self.transfer();
        }
    }

    /// Receives a break: the line is low for longer than a byte, which is one of zeros without a stop bit.
    pub(crate) fn receive_break(&self) {
        self.receive(0);
        self.framing_error.set(true);
    }

    /// A byte to memory, and round and round.
    fn transfer(&self) {
        let places = self.places();
        let data = self.get(places.peripheral);
        assert_eq!(data, places.received, "another peripheral");
        let ring = self.memory.get().expect("memory that the DMA reaches");
        let first = std::ptr::from_ref(ring).cast::<AtomicU8>();
        assert_eq!(self.get(places.memory), first.addr() as u32);
        let left = self.get(places.left);
        assert!(left > 0, "the transfer is over");
        let place = self.length.get() - left;
        assert!((place as usize) < size_of::<Ring>(), "beyond the memory");
        // SAFETY: the ring begins with its bytes, which are atomic, and the place is one of them.
        let target = unsafe { &*first.add(place as usize) };
        let Some(byte) = self.read_data() else { return };
        target.store(byte, Ordering::Relaxed);
        let next = left - 1;
        if next == self.length.get() / 2 {
            self.flag(HALF);
        }
        if next == 0 {
            self.flag(WHOLE);
        }
        let again = if next == 0 { self.length.get() } else { next };
        self.set(places.left, again);
    }

    /// The DMA is disabled by an error of a transfer.
    pub(crate) fn fail_transfer(&self) {
        let control = self.places().control;
        self.set(control, self.get(control) & !1);
        self.flag(ERROR);
    }

    fn flag(&self, event: usize) {
        let flags = self.places().flags;
        self.set(flags, self.get(flags) | FLAGS[event]);
        assert!(self.flags()[event]);
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let own = self.usart.word(address);
        own.map(|word| (Peripheral::Usart2, word)).or_else(|| {
            let word = self.dma.word(address);
            let word = word.or_else(|| self.own.word(address))?;
            Some((Peripheral::Dma1, word))
        })
    }

    fn get(&self, address: u32) -> u32 {
        self.find(address).map_or(0, |(_, word)| word.get())
    }

    fn set(&self, address: u32, word: u32) {
        if let Some((_, place)) = self.find(address) {
            place.set(word);
        }
    }

    /// Takes the byte out of the data register.
    fn read_data(&self) -> Option<u8> {
        if self.status_read.replace(false) && CLEARS_BY_READING {
            self.overrun.set(false);
            self.framing_error.set(false);
        }
        self.received.take()
    }

    /// Reads a word of it.
    pub(crate) fn read(&self, address: u32, word: &Cell<u32>) -> u32 {
        let places = self.places();
        if address == places.status {
            let bit = |there: bool, place: u32| u32::from(there) << place;
            self.status_read.set(true);
            let (framing_error, overrun) = (self.framing_error.get(), self.overrun.get());
            let can_send = !self.busy.get();
            word.set(
                bit(framing_error, 1)
                    | bit(overrun, 3)
                    | bit(self.received.get().is_some(), 5)
                    | bit(can_send, 7),
            );
            assert_eq!(self.status(), [framing_error, overrun, can_send]);
        } else if address == places.received {
            return self.read_data().unwrap_or(0).into();
        }
        word.get()
    }

    /// Writes a word of it.
    pub(crate) fn write(&self, address: u32, word: &Cell<u32>, new: u32) {
        let places = self.places();
        if address == places.sent {
            assert!(!self.busy.get(), "the byte before is lost");
            if self.is_open() {
                self.sent.borrow_mut().push(new as u8);
            }
        } else if !self.clear_flags(address, new) {
            let is_on = self.get(places.control) & 1 != 0;
            if [places.left, places.peripheral, places.memory].contains(&address) {
                assert!(!is_on, "the DMA is enabled");
            }
            if address == places.left {
                self.length.set(new);
            }
            if address == places.control && new & 1 != 0 && !is_on {
                self.check_start();
            }
            word.set(new);
        }
    }
}
