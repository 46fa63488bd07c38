//! USART2 of the STM32F4 (RM0090, 30), and the DMA stream of its reception (10).

use std::cell::Cell;

pub(crate) use crate::pac::dma2::RegisterBlock as Dma;
use crate::shared::model::clocks::Clocks;
use crate::shared::model::usart::Places;
pub(crate) use crate::shared::model::usart::Usart;

/// A read of the data after one of the status clears its errors (30.6.1).
pub(crate) const CLEARS_BY_READING: bool = true;

/// Flags of half a transfer, of a whole one, and of an error.
pub(crate) const FLAGS: [u32; 3] = [1 << 10, 1 << 11, 1 << 9];

/// The stream of USART2's reception, and its channel (table 42).
const STREAM: usize = 5;
const CHANNEL: u8 = 4;

/// It has nothing of its own.
#[derive(Default)]
pub(crate) struct Own();

impl Own {
    pub(crate) fn clear(&self) {}

    pub(crate) fn word(&self, _: u32) -> Option<&Cell<u32>> {
        None
    }
}

impl Usart {
    pub(crate) fn places(&self) -> Places {
        let (usart, dma) = (&self.usart, &self.dma);
        let stream = dma.st(STREAM);
        Places {
            status: usart.address(usart.sr()),
            received: usart.address(usart.dr()),
            sent: usart.address(usart.dr()),
            flags: dma.address(dma.hisr()),
            control: dma.address(stream.cr()),
            left: dma.address(stream.ndtr()),
            peripheral: dma.address(stream.par()),
            memory: dma.address(stream.m0ar()),
        }
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

    pub(crate) fn has_eight_bits(&self) -> bool {
        self.usart.cr1().read().m().is_m8()
    }

    /// The status: a framing error, an overrun, and that a byte can be sent.
    pub(crate) fn status(&self) -> [bool; 3] {
        let status = self.usart.sr().read();
        [status.fe().bit(), status.ore().bit(), status.txe().bit()]
    }

    pub(crate) fn flags(&self) -> [bool; 3] {
        let flags = self.dma.hisr().read();
        [
            flags.htif5().bit(),
            flags.tcif5().bit(),
            flags.teif5().bit(),
        ]
    }

    /// Clears flags by ones (10.5.4); false for another register.
    pub(crate) fn clear_flags(&self, address: u32, new: u32) -> bool {
        let dma = &self.dma;
        let clears = address == dma.address(dma.hifcr());
        if clears {
            dma.set(dma.hisr(), dma.get(dma.hisr()) & !new);
        }
        clears
    }

    /// True if the stream is on, and moves bytes from USART2 to memory (10.3.8 and 10.3.9).
    pub(crate) fn takes_received_bytes(&self) -> bool {
        let control = self.dma.st(STREAM).cr().read();
        let is_on = control.en().is_enabled() && control.chsel().bits() == CHANNEL;
        let moves_bytes = control.dir().is_peripheral_to_memory()
            && control.psize().is_bits8()
            && control.msize().is_bits8()
            && control.minc().is_incremented()
            && control.pinc().is_fixed()
            && control.circ().is_enabled()
            && control.pfctrl().is_dma();
        assert!(!is_on || moves_bytes, "from one register to many places");
        is_on
    }

    pub(crate) fn check_start(&self) {
        let flags = self.dma.get(self.dma.hisr()) >> 6 & 0b11_1101;
        assert_eq!(flags, 0, "flags of an earlier transfer (10.3.17)");
    }

    /// The stream's priority over others, 3 is the highest.
    pub(crate) fn priority(&self) -> u8 {
        self.dma.st(STREAM).cr().read().pl().bits()
    }
}
