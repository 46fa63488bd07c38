//! The reception of USART2 by stream 5 of DMA1 (RM0090, 10 and 30).

use super::F4;
use super::registers::{dma, usart};
use crate::family::Bus;

/// As [`Family::receive_into`](crate::family::Family::receive_into). This stream goes before every other.
pub(super) fn into_memory(bus: impl Bus<Family = F4>, place: u32, length: u32) {
    bus.write(dma::S5PAR, usart::DR.address());
    bus.write(dma::S5M0AR, place);
    bus.write(dma::S5NDTR, length);
    let mode = dma::CR_CHANNEL_4 | dma::CR_PL_HIGHEST | dma::CR_MINC | dma::CR_CIRC;
    // The rest is written before it is enabled (RM0090, 10.3.17).
    bus.write(dma::S5CR, mode);
    bus.write(dma::S5CR, mode | dma::CR_EN);
}

/// Reading the data after the status clears the errors (RM0090, 30.6.1).
pub(super) fn clear_errors(bus: impl Bus<Family = F4>) {
    let _ = bus.read(usart::DR);
}
