//! A serial line without waiting: an interrupt moves bytes between USART2 and two queues.

use core::fmt;

use drive_link::MAX_FRAME_BYTES;
use heapless::spsc::{Consumer, Producer, Queue};

use crate::bus::Bus;
use crate::clock::Clocks;
use crate::interrupts;
use crate::registers::usart;

/// Bits per second: exactly 42 ticks of the bus with the PLL and 16 without. The 921 600 that hosts often
/// offer would be 0.93 % too slow and 2.1 % too fast (RM0090, 30.3.4).
pub const BAUD: u32 = 1_000_000;

/// Length of a queue, bytes: at least two whole frames, and a power of two, so that it masks where it
/// would divide.
const QUEUE_LENGTH: usize = 2048;
const _: () = assert!(QUEUE_LENGTH > 2 * MAX_FRAME_BYTES);

/// Bytes that were received, or are to be sent.
pub type Bytes = Queue<u8, QUEUE_LENGTH>;

/// The background's end.
pub struct Line<'a, B> {
    bus: B,
    received: Consumer<'a, u8, QUEUE_LENGTH>,
    to_send: Producer<'a, u8, QUEUE_LENGTH>,
}

/// The interrupt's end.
pub struct Port<'a, B> {
    bus: B,
    /// The USART interrupts when it can take a byte.
    is_sending: bool,
    received: Producer<'a, u8, QUEUE_LENGTH>,
    to_send: Consumer<'a, u8, QUEUE_LENGTH>,
}

impl<B> fmt::Debug for Line<'_, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Line").finish_non_exhaustive()
    }
}

impl<B> fmt::Debug for Port<'_, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Port").finish_non_exhaustive()
    }
}

/// Both ends of a line of 8 bits without parity, of a USART that is as after reset.
pub(crate) fn line<'a, B: Bus>(
    bus: B,
    clocks: &Clocks,
    received: &'a mut Bytes,
    to_send: &'a mut Bytes,
) -> (Line<'a, B>, Port<'a, B>) {
    let (put_received, received) = received.split();
    let (to_send, take_to_send) = to_send.split();
    // With sixteenfold sampling the divider's four fraction bits are the low ones. Eightfold sampling
    // has one fraction bit less and the same steps, one tick of the bus a bit, and bears less of the
    // other end's error (RM0090, 30.3.4 and 30.3.5).
    bus.write(usart::BRR, (clocks.low_bus + BAUD / 2) / BAUD);
    bus.write(
        usart::CR1,
        usart::CR1_UE | usart::CR1_TE | usart::CR1_RE | usart::CR1_RXNEIE,
    );
    let port = Port {
        bus,
        is_sending: false,
        received: put_received,
        to_send: take_to_send,
    };
    (
        Line {
            bus,
            received,
            to_send,
        },
        port,
    )
}

impl<B> Line<'_, B> {
    /// True while no received byte waits.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.received.len() == 0
    }
}

impl<B: Bus> drive_link::Line for Line<'_, B> {
    fn receive(&mut self) -> Option<u8> {
        self.received.dequeue()
    }

    fn room(&self) -> usize {
        self.to_send.capacity() - self.to_send.len()
    }

    fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let _ = self.to_send.enqueue(byte);
        }
        // The interrupt takes the first byte.
        interrupts::pend_serial(self.bus);
    }
}

impl<B: Bus> Port<'_, B> {
    /// Serves the interrupt.
    pub fn serve(&mut self) {
        let bus = self.bus;
        let status = bus.read(usart::SR);
        // Reading clears an overrun too; a lost byte spoils its frame, whose checksum shows it.
        if status & (usart::SR_RXNE | usart::SR_ORE) != 0 {
            let _ = self.received.enqueue(bus.read(usart::DR) as u8);
        }
        if status & usart::SR_TXE != 0 {
            match self.to_send.dequeue() {
                Some(byte) => {
                    bus.write(usart::DR, u32::from(byte));
                    if !self.is_sending {
                        self.is_sending = true;
                        bus.modify(usart::CR1, 0, usart::CR1_TXEIE);
                    }
                }
                None => {
                    self.is_sending = false;
                    bus.modify(usart::CR1, usart::CR1_TXEIE, 0);
                }
            }
        }
    }
}
