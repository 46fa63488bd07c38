//! USART2 (RM0440, USART), and the DMA channel of its reception with the multiplexer (DMA and DMAMUX).

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicU8, Ordering};

use drive_chip::serial::Ring;

use super::block::Block;
use super::clocks::Peripheral;
use crate::pac::{DMA1, DMAMUX, USART2, dma1, dmamux, usart1};
use crate::shared::model::clocks::Clocks;

pub(crate) struct Usart {
    usart: Block<usart1::RegisterBlock>,
    dma: Block<dma1::RegisterBlock>,
    multiplexer: Block<dmamux::RegisterBlock>,
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
}

/// The request of USART2's reception (DMAMUX).
const REQUEST: u8 = 26;

impl Usart {
    pub(crate) fn new() -> Self {
        Self {
            usart: Block::at(USART2::ptr()),
            dma: Block::at(DMA1::ptr()),
            multiplexer: Block::at(DMAMUX::ptr()),
            memory: Cell::new(None),
            length: Cell::new(0),
            received: Cell::new(None),
            sent: RefCell::default(),
            busy: Cell::new(false),
            overrun: Cell::new(false),
            framing_error: Cell::new(false),
        }
    }

    pub(crate) fn reset(&self) {
        self.usart.clear();
    }

    pub(crate) fn reset_dma(&self) {
        self.dma.clear();
        self.multiplexer.clear();
    }

    /// Lets the DMA reach a ring.
    pub(crate) fn reach(&self, ring: &'static Ring) {
        self.memory.set(Some(ring));
    }

    /// Bits a second, with sixteenfold sampling (USART).
    pub(crate) fn baud(&self, clocks: &Clocks) -> f64 {
        assert!(!self.usart.cr1().read().over8().bit());
        assert_eq!(self.usart.get(self.usart.presc()), 0);
        let divider = self.usart.get(self.usart.brr());
        assert!(divider >= 16, "at least 16 (USART)");
        clocks.frequencies().low_bus / f64::from(divider)
    }

    /// True if it receives and sends words of eight bits without parity and without a queue.
    pub(crate) fn is_open(&self) -> bool {
        let control = self.usart.cr1().read();
        control.ue().bit()
            && control.te().bit()
            && control.re().bit()
            && !control.m0().bit()
            && !control.m1().bit()
            && !control.pce().bit()
            && !control.fifoen().bit()
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
        if self.usart.cr3().read().dmar().bit() {
            self.transfer();
        }
    }

    /// Receives a break: the line is low for longer than a byte, which is one of zeros without a stop bit (USART).
    pub(crate) fn receive_break(&self) {
        self.receive(0);
        self.framing_error.set(true);
    }

    /// A byte to memory (DMA).
    fn transfer(&self) {
        let channel = self.dma.ch(0);
        let control = channel.cr().read();
        let chosen = self.multiplexer.ccr(0).read().dmareq_id().bits();
        if !control.en().bit() || chosen != REQUEST {
            return;
        }
        let data = self.usart.address(self.usart.rdr());
        assert_eq!(channel.par().read().bits(), data, "another peripheral");
        assert!(
            !control.dir().bit()
                && control.psize().bits() == 0
                && control.msize().bits() == 0
                && control.minc().bit()
                && !control.pinc().bit()
                && !control.mem2mem().bit(),
            "bytes from one register to many places"
        );
        let ring = self.memory.get().expect("memory that the DMA reaches");
        let first = std::ptr::from_ref(ring).cast::<AtomicU8>();
        assert_eq!(channel.mar().read().bits(), first.addr() as u32);
        let left = u32::from(channel.ndtr().read().ndt().bits());
        assert!(left > 0, "the transfer is over");
        let place = self.length.get() - left;
        assert!((place as usize) < size_of::<Ring>(), "beyond the memory");
        // SAFETY: the ring begins with its bytes, which are atomic, and the place is one of them.
        let target = unsafe { &*first.add(place as usize) };
        let Some(byte) = self.received.take() else {
            return;
        };
        target.store(byte, Ordering::Relaxed);
        let next = left - 1;
        if next == self.length.get() / 2 {
            self.flag(2);
            assert!(self.dma.isr().read().htif1().bit());
        }
        if next == 0 {
            self.flag(1);
            assert!(self.dma.isr().read().tcif1().bit());
        }
        let reloaded = if next > 0 {
            next
        } else if control.circ().bit() {
            self.length.get()
        } else {
            0
        };
        self.dma.set(channel.ndtr(), reloaded);
    }

    /// The channel is disabled by an error of a transfer (DMA).
    pub(crate) fn fail_transfer(&self) {
        let channel = self.dma.ch(0);
        self.dma.set(channel.cr(), self.dma.get(channel.cr()) & !1);
        self.flag(3);
        assert!(self.dma.isr().read().teif1().bit());
    }

    /// Sets a flag of channel 1 and the flag for all of them.
    fn flag(&self, bit: u32) {
        let flags = self.dma.get(self.dma.isr());
        self.dma.set(self.dma.isr(), flags | 1 << bit | 1);
    }

    /// The channel's priority over others, 3 is the highest.
    pub(crate) fn priority(&self) -> u8 {
        self.dma.ch(0).cr().read().pl().bits()
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let own = self.usart.word(address);
        own.map(|word| (Peripheral::Usart2, word)).or_else(|| {
            let word = self.dma.word(address);
            let word = word.or_else(|| self.multiplexer.word(address))?;
            Some((Peripheral::Dma1, word))
        })
    }

    /// Reads a word of it.
    pub(crate) fn read(&self, address: u32, word: &Cell<u32>) -> u32 {
        let usart = &self.usart;
        if address == usart.address(usart.isr()) {
            let bit = |there: bool, place: u32| u32::from(there) << place;
            word.set(
                bit(self.framing_error.get(), 1)
                    | bit(self.overrun.get(), 3)
                    | bit(self.received.get().is_some(), 5)
                    | bit(!self.busy.get(), 7),
            );
            let shown = usart.isr().read();
            assert_eq!(shown.fe().bit(), self.framing_error.get());
            assert_eq!(shown.ore().bit(), self.overrun.get());
        } else if address == usart.address(usart.rdr()) {
            return self.received.take().unwrap_or(0).into();
        }
        word.get()
    }

    /// Writes a word of it.
    pub(crate) fn write(&self, address: u32, word: &Cell<u32>, new: u32) {
        let usart = &self.usart;
        if address == usart.address(usart.tdr()) {
            assert!(!self.busy.get(), "the byte before is lost (USART)");
            if self.is_open() {
                self.sent.borrow_mut().push(new as u8);
            }
        } else if address == usart.address(usart.icr()) {
            // Ones clear (USART).
            if new & 1 << 1 != 0 {
                self.framing_error.set(false);
            }
            if new & 1 << 3 != 0 {
                self.overrun.set(false);
            }
        } else if address == self.dma.address(self.dma.ifcr()) {
            // Ones clear (DMA).
            assert!(new & 1 == 0, "all flags, one that was not seen yet too");
            let flags = self.dma.get(self.dma.isr());
            self.dma.set(self.dma.isr(), flags & !new);
        } else {
            assert!(address != usart.address(usart.isr()), "it is read-only");
            self.write_dma(address, new);
            word.set(new);
        }
    }

    /// Checks a write to the channel.
    fn write_dma(&self, address: u32, new: u32) {
        let channel = self.dma.ch(0);
        let is_on = channel.cr().read().en().bit();
        let settings = [
            self.dma.address(channel.ndtr()),
            self.dma.address(channel.par()),
            self.dma.address(channel.mar()),
        ];
        if settings.contains(&address) {
            assert!(!is_on, "the channel is enabled (DMA)");
        }
        if address == settings[0] {
            self.length.set(new);
        }
        if address == self.dma.address(channel.cr()) && new & 1 != 0 && !is_on {
            let failed = self.dma.isr().read().teif1().bit();
            assert!(!failed, "not before the error's flag is cleared (DMA)");
        }
    }
}
