//! A serial line without waiting. DMA receives into a ring, however long an interrupt takes. An interrupt listens to
//! the ring and sends from a queue.

use core::fmt;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use drive_link::MAX_FRAME_BYTES;
use heapless::spsc::{Consumer, Producer, Queue};

use crate::clock::Clocks;
use crate::family::{Bus, Receiver};
use crate::interrupts;
use crate::registers::usart;

/// Bits per second. A bit is exactly 42 ticks of an STM32F4's bus, 170 of an STM32G4's with the PLL, and 16 without.
/// The 921 600 that hosts often offer would be 0.93 % too slow and 2.1 % too fast (RM0090, 30.3.4).
pub const BAUD: u32 = 1_000_000;

/// Length of the send queue, bytes. It is at least two whole frames, and a power of two, so that a mask replaces a
/// division.
const QUEUE_LENGTH: usize = 2048;
const _: () = assert!(QUEUE_LENGTH > 2 * MAX_FRAME_BYTES);

/// Bytes that are to be sent.
pub type Bytes = Queue<u8, QUEUE_LENGTH>;

/// Length of the ring, bytes: those of 41 ms. One half waits to be decoded while the other is received into.
pub(crate) const RING_LENGTH: u32 = 4096;
const HALF: u32 = RING_LENGTH / 2;
const _: () = assert!(RING_LENGTH.is_power_of_two() && HALF as usize > 2 * MAX_FRAME_BYTES);

/// The memory that bytes are received into.
#[derive(Debug)]
#[repr(C)]
pub struct Ring {
    bytes: [AtomicU8; RING_LENGTH as usize],
    /// Bytes that the interrupt has listened to since the beginning.
    heard: AtomicU32,
}

impl Ring {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [const { AtomicU8::new(0) }; RING_LENGTH as usize],
            heard: AtomicU32::new(0),
        }
    }

    /// The byte of a number, counted from the beginning.
    fn byte(&self, number: u32) -> u8 {
        let place = number % RING_LENGTH;
        self.bytes
            .get(place as usize)
            .map_or(0, |byte| byte.load(Ordering::Relaxed))
    }
}

impl Default for Ring {
    fn default() -> Self {
        Self::new()
    }
}

/// The background's end.
pub struct Line<'a, B> {
    bus: B,
    ring: &'static Ring,
    /// Bytes that were taken since the beginning.
    taken: u32,
    to_send: Producer<'a, u8, QUEUE_LENGTH>,
}

/// The interrupt's end.
pub struct Port<'a, B> {
    bus: B,
    ring: &'static Ring,
    /// The USART interrupts when it can take a byte.
    is_sending: bool,
    to_send: Consumer<'a, u8, QUEUE_LENGTH>,
}

/// An event of the reception.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reception {
    /// A byte.
    Byte(u8),
    /// An overrun, a framing error or a break: bytes were lost or damaged.
    Disturbed,
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

/// Both ends of a line of 8 bits without parity. USART and DMA stream are in their reset state.
pub fn line<'a, B: Bus>(
    bus: B,
    clocks: &Clocks,
    ring: &'static Ring,
    to_send: &'a mut Bytes,
) -> (Line<'a, B>, Port<'a, B>) {
    let (to_send, take_to_send) = to_send.split();
    // With sixteenfold sampling the divider's four fraction bits are the low ones. Eightfold sampling has one fraction
    // bit less and the same steps of one bus tick per bit. It tolerates a smaller error of the other end (RM0090,
    // 30.3.4 and 30.3.5).
    let usart = B::Family::USART;
    bus.write(usart.divider, (clocks.low_bus + BAUD / 2) / BAUD);
    receive_into(bus, ring);
    bus.write(usart.control_3, usart::CR3_DMAR);
    // An emulated chip has no DMA: an interrupt stands in for it.
    let instead = if cfg!(feature = "emulator") {
        usart::CR1_RXNEIE
    } else {
        0
    };
    bus.write(
        usart.control_1,
        usart.enable | usart::CR1_TE | usart::CR1_RE | instead,
    );
    let port = Port {
        bus,
        ring,
        is_sending: false,
        to_send: take_to_send,
    };
    (
        Line {
            bus,
            ring,
            taken: 0,
            to_send,
        },
        port,
    )
}

/// Has every byte that is received written to the ring, from its beginning. A byte must be taken within 10 µs.
fn receive_into<B: Bus>(bus: B, ring: &'static Ring) {
    B::Family::receive_into(bus, ring.bytes.as_ptr() as u32, RING_LENGTH);
}

impl<B> Line<'_, B> {
    /// True while no received byte waits.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.ring.heard.load(Ordering::Acquire) == self.taken
    }
}

impl<B: Bus> drive_link::Line for Line<'_, B> {
    fn listen(&mut self) {
        interrupts::pend_serial(self.bus);
        self.bus.take_interrupts();
    }

    fn receive(&mut self) -> Option<u8> {
        let heard = self.ring.heard.load(Ordering::Acquire);
        let waiting = heard.wrapping_sub(self.taken);
        if waiting > HALF {
            // They may be overwritten. Frames are lost, which a host repeats, and no stop: it was heard.
            self.taken = heard;
            return None;
        }
        if waiting == 0 {
            return None;
        }
        let byte = self.ring.byte(self.taken);
        self.taken = self.taken.wrapping_add(1);
        Some(byte)
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
    /// Serves the interrupt, and hands on all that was received since the last time.
    #[inline]
    pub fn serve(&mut self, mut take: impl FnMut(Reception)) {
        let bus = self.bus;
        let status = bus.read(B::Family::USART.status);
        if status & (usart::SR_ORE | usart::SR_FE) != 0 {
            B::Family::clear_reception_errors(bus);
            take(Reception::Disturbed);
        }
        self.listen(take);
        if status & usart::SR_TXE != 0 {
            self.send();
        }
    }

    #[inline]
    fn listen(&mut self, mut take: impl FnMut(Reception)) {
        let bus = self.bus;
        let reception = B::Family::RECEPTION;
        let flags = bus.read(reception.flags) & reception.all;
        if flags != 0 {
            bus.write(reception.clear, flags);
        }
        let heard = self.ring.heard.load(Ordering::Relaxed);
        let place = RING_LENGTH.wrapping_sub(bus.read(reception.left));
        let arrived = place.wrapping_sub(heard) % RING_LENGTH;
        let (first, end) = if flags & reception.failed != 0 {
            // An error of the transfer has disabled the stream.
            receive_into(bus, self.ring);
            let anew = heard.wrapping_add(2 * RING_LENGTH) & !(RING_LENGTH - 1);
            (anew, anew)
        } else if flags & reception.round == reception.round {
            // Both marks were passed, so at least half of the ring was filled since the last time, perhaps several
            // times over. The newest half is whole.
            let end = heard.wrapping_add(RING_LENGTH + arrived);
            (end.wrapping_sub(HALF), end)
        } else {
            (heard, heard.wrapping_add(arrived))
        };
        if first != heard {
            take(Reception::Disturbed);
        }
        for number in 0..end.wrapping_sub(first) {
            take(Reception::Byte(self.ring.byte(first.wrapping_add(number))));
        }
        self.ring.heard.store(end, Ordering::Release);
    }

    fn send(&mut self) {
        let bus = self.bus;
        match self.to_send.dequeue() {
            Some(byte) => {
                bus.write(B::Family::USART.transmit, u32::from(byte));
                if !self.is_sending {
                    self.is_sending = true;
                    bus.modify(B::Family::USART.control_1, 0, usart::CR1_TXEIE);
                }
            }
            None => {
                self.is_sending = false;
                bus.modify(B::Family::USART.control_1, usart::CR1_TXEIE, 0);
            }
        }
    }
}
