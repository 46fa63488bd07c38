//! USART2 (RM0090, 30), and the DMA stream of its reception (10).

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicU8, Ordering};

use drive_chip::serial::Ring;
use stm32f4::stm32f405::{DMA1, USART2, dma2, usart1};

use super::block::Block;
use super::clocks::Peripheral;
use crate::shared::model::clocks::Clocks;

pub(crate) struct Usart {
    usart: Block<usart1::RegisterBlock>,
    dma: Block<dma2::RegisterBlock>,
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

/// The stream of USART2's reception, and its channel (table 42).
const STREAM: usize = 5;
const CHANNEL: u8 = 4;

impl Usart {
    pub(crate) fn new() -> Self {
        Self {
            usart: Block::at(USART2::ptr()),
            dma: Block::at(DMA1::ptr()),
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
    }

    /// Lets the DMA reach a ring.
    pub(crate) fn reach(&self, ring: &'static Ring) {
        self.memory.set(Some(ring));
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
        if self.usart.cr3().read().dmar().is_enabled() {
            self.transfer();
        }
    }

    /// Receives a break: the line is low for longer than a byte, which is one of zeros without a stop bit (30.3.3).
    pub(crate) fn receive_break(&self) {
        self.receive(0);
        self.framing_error.set(true);
    }

    /// A byte to memory (10.3.8 and 10.3.9).
    fn transfer(&self) {
        let stream = self.dma.st(STREAM);
        let control = stream.cr().read();
        if control.en().is_disabled() || control.chsel().bits() != CHANNEL {
            return;
        }
        let data = self.usart.address(self.usart.dr());
        assert_eq!(stream.par().read().bits(), data, "another peripheral");
        assert!(
            control.dir().is_peripheral_to_memory()
                && control.psize().is_bits8()
                && control.msize().is_bits8()
                && control.minc().is_incremented()
                && control.pinc().is_fixed()
                && control.pfctrl().is_dma(),
            "bytes from one register to many places"
        );
        let ring = self.memory.get().expect("memory that the DMA reaches");
        let first = std::ptr::from_ref(ring).cast::<AtomicU8>();
        assert_eq!(stream.m0ar().read().bits(), first.addr() as u32);
        let left = stream.ndtr().read().ndt().bits();
        assert!(left > 0, "the transfer is over");
        let place = self.length.get() - u32::from(left);
        assert!((place as usize) < size_of::<Ring>(), "beyond the memory");
        // SAFETY: the ring begins with its bytes, which are atomic, and the place is one of them.
        let target = unsafe { &*first.add(place as usize) };
        let Some(byte) = self.read_data() else { return };
        target.store(byte, Ordering::Relaxed);
        let next = u32::from(left) - 1;
        let half = self.length.get() / 2;
        if next == half {
            self.flag(10);
            assert!(self.dma.hisr().read().htif5().bit());
        }
        if next == 0 {
            self.flag(11);
            assert!(self.dma.hisr().read().tcif5().bit());
        }
        let reloaded = if next > 0 {
            next
        } else if control.circ().is_enabled() {
            self.length.get()
        } else {
            self.dma.set(stream.cr(), self.dma.get(stream.cr()) & !1);
            0
        };
        self.dma.set(stream.ndtr(), reloaded);
    }

    /// The stream is disabled by an error of a transfer (10.3.18).
    pub(crate) fn fail_transfer(&self) {
        let stream = self.dma.st(STREAM);
        self.dma.set(stream.cr(), self.dma.get(stream.cr()) & !1);
        self.flag(9);
        assert!(self.dma.hisr().read().teif5().bit());
    }

    fn flag(&self, bit: u32) {
        let flags = self.dma.get(self.dma.hisr());
        self.dma.set(self.dma.hisr(), flags | 1 << bit);
    }

    /// The stream's priority over others, 3 is the highest.
    pub(crate) fn priority(&self) -> u8 {
        self.dma.st(STREAM).cr().read().pl().bits()
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let own = self.usart.word(address);
        own.map(|word| (Peripheral::Usart2, word)).or_else(|| {
            let word = self.dma.word(address)?;
            Some((Peripheral::Dma1, word))
        })
    }

    /// Takes the byte out of the data register; after the status was read that clears its errors (30.6.1).
    fn read_data(&self) -> Option<u8> {
        if self.status_read.replace(false) {
            self.overrun.set(false);
            self.framing_error.set(false);
        }
        self.received.take()
    }

    /// Reads a word of it.
    pub(crate) fn read(&self, address: u32, word: &Cell<u32>) -> u32 {
        let usart = &self.usart;
        if address == usart.address(usart.sr()) {
            let bit = |there: bool, place: u32| u32::from(there) << place;
            self.status_read.set(true);
            word.set(
                bit(self.framing_error.get(), 1)
                    | bit(self.overrun.get(), 3)
                    | bit(self.received.get().is_some(), 5)
                    | bit(!self.busy.get(), 7),
            );
            let shown = usart.sr().read();
            assert_eq!(shown.fe().bit(), self.framing_error.get());
            assert_eq!(shown.ore().is_overrun(), self.overrun.get());
            assert_eq!(shown.txe().is_tx_empty(), !self.busy.get());
        } else if address == usart.address(usart.dr()) {
            return self.read_data().unwrap_or(0).into();
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
        } else if address == self.dma.address(self.dma.hifcr()) {
            // Ones clear (10.5.4).
            let flags = self.dma.get(self.dma.hisr());
            self.dma.set(self.dma.hisr(), flags & !new);
        } else {
            self.write_dma(address, new);
            word.set(new);
        }
    }

    /// Checks a write to the stream.
    fn write_dma(&self, address: u32, new: u32) {
        let stream = self.dma.st(STREAM);
        let is_on = stream.cr().read().en().is_enabled();
        let settings = [
            self.dma.address(stream.ndtr()),
            self.dma.address(stream.par()),
            self.dma.address(stream.m0ar()),
        ];
        if settings.contains(&address) {
            assert!(!is_on, "the stream is enabled (10.5.6)");
        }
        if address == settings[0] {
            self.length.set(new);
        }
        let starts = address == self.dma.address(stream.cr()) && new & 1 != 0 && !is_on;
        if starts {
            let flags = self.dma.get(self.dma.hisr()) >> 6 & 0b11_1101;
            assert_eq!(flags, 0, "flags of an earlier transfer (10.3.17)");
        }
    }
}
