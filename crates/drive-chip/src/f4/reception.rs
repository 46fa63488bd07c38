//! The reception of USART2 by stream 5 of DMA1 (RM0090, 10 and 30).

use super::Stm32F4;
use super::registers::{dma, usart};
use crate::family::{Bus, Receiver, Reception, Usart};

impl<const MEGAHERTZ: u32> Receiver for Stm32F4<MEGAHERTZ> {
    const USART: Usart = Usart {
        status: usart::SR,
        transmit: usart::DR,
        divider: usart::BRR,
        control_1: usart::CR1,
        control_3: usart::CR3,
        enable: usart::CR1_UE,
    };
    const RECEPTION: Reception = Reception {
        flags: dma::HISR,
        clear: dma::HIFCR,
        left: dma::S5NDTR,
        round: dma::HTIF5 | dma::TCIF5,
        failed: dma::TEIF5,
        all: dma::HTIF5 | dma::TCIF5 | dma::TEIF5 | dma::DMEIF5 | dma::FEIF5,
    };

    fn receive_into(bus: impl Bus<Family = Self>, place: u32, length: u32) {
        bus.write(dma::S5PAR, usart::DR.address());
        bus.write(dma::S5M0AR, place);
        bus.write(dma::S5NDTR, length);
        let mode = dma::CR_CHANNEL_4 | dma::CR_PL_HIGHEST | dma::CR_MINC | dma::CR_CIRC;
        // The rest is written before it is enabled (RM0090, 10.3.17).
        bus.write(dma::S5CR, mode);
        bus.write(dma::S5CR, mode | dma::CR_EN);
    }

    /// Reading the data after the status clears the errors (RM0090, 30.6.1).
    fn clear_reception_errors(bus: impl Bus<Family = Self>) {
        let _ = bus.read(usart::DR);
    }
}
