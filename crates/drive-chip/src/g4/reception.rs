//! The reception of USART2 by channel 1 of DMA1, to which the multiplexer brings its requests (RM0440, DMA, DMAMUX and USART).

use super::G4;
use super::registers::{dma, usart};
use crate::family::Bus;
use crate::registers::usart::{SR_FE, SR_ORE};

/// As [`Family::receive_into`](crate::family::Family::receive_into). This channel goes before every other.
pub(super) fn into_memory(bus: impl Bus<Family = G4>, place: u32, length: u32) {
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
pub(super) fn clear_errors(bus: impl Bus<Family = G4>) {
    bus.write(usart::ICR, SR_ORE | SR_FE);
}
