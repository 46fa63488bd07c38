//! The reception of USART2 by channel 1 of DMA1. The multiplexer brings the requests to it (RM0440, DMA, DMAMUX and
//! USART).

use super::G4;
use super::registers::{dma, usart};
use crate::family::{Bus, Receiver, Reception, Usart};
use crate::registers::usart::{SR_FE, SR_ORE};

impl Receiver for G4 {
    const USART: Usart = Usart {
        status: usart::ISR,
        transmit: usart::TDR,
        divider: usart::BRR,
        control_1: usart::CR1,
        control_3: usart::CR3,
        enable: usart::CR1_UE,
    };
    const RECEPTION: Reception = Reception {
        flags: dma::ISR,
        clear: dma::IFCR,
        left: dma::CNDTR1,
        round: dma::HTIF1 | dma::TCIF1,
        failed: dma::TEIF1,
        all: dma::HTIF1 | dma::TCIF1 | dma::TEIF1,
    };

    fn receive_into(bus: impl Bus<Family = Self>, place: u32, length: u32) {
        bus.write(dma::C0CR, dma::REQUEST_USART2_RX);
        bus.write(dma::CPAR1, usart::RDR.address());
        bus.write(dma::CMAR1, place);
        bus.write(dma::CNDTR1, length);
        let mode = dma::CCR_PL_HIGHEST | dma::CCR_MINC | dma::CCR_CIRC;
        // The rest is written before it is enabled (RM0440, DMA).
        bus.write(dma::CCR1, mode);
        bus.write(dma::CCR1, mode | dma::CCR_EN);
    }

    /// Ones at the places of the flags clear them (RM0440, USART): reading the data does not.
    fn clear_reception_errors(bus: impl Bus<Family = Self>) {
        bus.write(usart::ICR, SR_ORE | SR_FE);
    }
}
