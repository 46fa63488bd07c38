//! The DMA stream of the reception, which an emulated chip lacks.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use crate::emulated::{get, set};
use crate::f4::F4;
use crate::f4::registers::{dma, usart};
use crate::family::Bus;
use crate::mmio::Mmio;
use crate::registers::usart::SR_RXNE;
use crate::serial::RING_LENGTH;

const BUS: Mmio<F4> = Mmio::BUS;

/// Receives a byte as the DMA stream does, if USART2 has one. Its interrupt replaces the stream's request.
pub fn receive() {
    if BUS.read(usart::SR) & SR_RXNE == 0 {
        return;
    }
    let byte = BUS.read(usart::DR) as u8;
    let left = get(dma::S5NDTR);
    let place = get(dma::S5M0AR) + RING_LENGTH.wrapping_sub(left);
    // SAFETY: the stream's memory is a ring of atomic bytes of this length, which is static.
    unsafe { &*(place as *const AtomicU8) }.store(byte, Relaxed);
    let (left, mark) = match left {
        1 => (RING_LENGTH, dma::TCIF5),
        _ if left == RING_LENGTH / 2 + 1 => (left - 1, dma::HTIF5),
        _ => (left - 1, 0),
    };
    set(dma::S5NDTR, left);
    set(dma::HISR, get(dma::HISR) | mark);
}
