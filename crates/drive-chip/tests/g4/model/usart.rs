//! USART2 of the STM32G4 (RM0440, USART), and the DMA channel of its reception with the multiplexer (DMA and DMAMUX).

use std::cell::Cell;

use super::block::Block;
pub(crate) use crate::pac::dma1::RegisterBlock as Dma;
use crate::pac::{DMAMUX, dmamux};
use crate::shared::model::clocks::Clocks;
use crate::shared::model::usart::Places;
pub(crate) use crate::shared::model::usart::Usart;

/// The status has a register that clears its errors.
pub(crate) const CLEARS_BY_READING: bool = false;

/// Flags of half a transfer, of a whole one, and of an error, each with the flag for all of them.
pub(crate) const FLAGS: [u32; 3] = [1 << 2 | 1, 1 << 1 | 1, 1 << 3 | 1];

/// The request of USART2's reception (DMAMUX).
const REQUEST: u8 = 26;

/// The multiplexer.
pub(crate) struct Own(Block<dmamux::RegisterBlock>);

impl Default for Own {
    fn default() -> Self {
        Self(Block::at(DMAMUX::ptr()))
    }
}

impl Own {
    pub(crate) fn clear(&self) {
        self.0.clear();
    }

    pub(crate) fn word(&self, address: u32) -> Option<&Cell<u32>> {
        self.0.word(address)
    }
}

impl Usart {
    pub(crate) fn places(&self) -> Places {
        let (usart, dma) = (&self.usart, &self.dma);
        let channel = dma.ch(0);
        Places {
            status: usart.address(usart.isr()),
            received: usart.address(usart.rdr()),
            sent: usart.address(usart.tdr()),
            flags: dma.address(dma.isr()),
            control: dma.address(channel.cr()),
            left: dma.address(channel.ndtr()),
            peripheral: dma.address(channel.par()),
            memory: dma.address(channel.mar()),
        }
    }

    /// Bits a second, with sixteenfold sampling (USART).
    pub(crate) fn baud(&self, clocks: &Clocks) -> f64 {
        assert!(!self.usart.cr1().read().over8().bit());
        assert_eq!(self.usart.get(self.usart.presc()), 0);
        let divider = self.usart.get(self.usart.brr());
        assert!(divider >= 16, "at least 16 (USART)");
        clocks.frequencies().low_bus / f64::from(divider)
    }

    /// True without a queue too.
    pub(crate) fn has_eight_bits(&self) -> bool {
        let control = self.usart.cr1().read();
        !control.m0().bit() && !control.m1().bit() && !control.fifoen().bit()
    }

    /// The status: a framing error, an overrun, and that a byte can be sent.
    pub(crate) fn status(&self) -> [bool; 3] {
        let status = self.usart.isr().read();
        [status.fe().bit(), status.ore().bit(), status.txe().bit()]
    }

    pub(crate) fn flags(&self) -> [bool; 3] {
        let flags = self.dma.isr().read();
        [
            flags.htif1().bit(),
            flags.tcif1().bit(),
            flags.teif1().bit(),
        ]
    }

    /// Clears flags by ones (USART, DMA); false for another register.
    pub(crate) fn clear_flags(&self, address: u32, new: u32) -> bool {
        let (usart, dma) = (&self.usart, &self.dma);
        assert!(address != usart.address(usart.isr()), "it is read-only");
        if address == usart.address(usart.icr()) {
            let stays = |flag: &Cell<bool>, bit: u32| flag.set(flag.get() && new >> bit & 1 == 0);
            stays(&self.framing_error, 1);
            stays(&self.overrun, 3);
        } else if address == dma.address(dma.ifcr()) {
            assert!(new & 1 == 0, "all flags, one that was not seen yet too");
            dma.set(dma.isr(), dma.get(dma.isr()) & !new);
        } else {
            return false;
        }
        true
    }

    /// True if the channel is on, and moves bytes from USART2 to memory (DMA).
    pub(crate) fn takes_received_bytes(&self) -> bool {
        let control = self.dma.ch(0).cr().read();
        let chosen = self.own.0.ccr(0).read().dmareq_id().bits();
        let is_on = control.en().bit() && chosen == REQUEST;
        let moves_bytes = !control.dir().bit()
            && control.psize().bits() == 0
            && control.msize().bits() == 0
            && control.minc().bit()
            && !control.pinc().bit()
            && control.circ().bit()
            && !control.mem2mem().bit();
        assert!(!is_on || moves_bytes, "from one register to many places");
        is_on
    }

    pub(crate) fn check_start(&self) {
        let failed = self.dma.isr().read().teif1().bit();
        assert!(!failed, "not before the error's flag is cleared (DMA)");
    }

    /// The channel's priority over others, 3 is the highest.
    pub(crate) fn priority(&self) -> u8 {
        self.dma.ch(0).cr().read().pl().bits()
    }
}
