//! A serial line that nobody waits for: an interrupt moves bytes between USART2 and two queues.

use core::fmt;

use drive_link::LONGEST_FRAME;
use heapless::spsc::{Consumer, Producer, Queue};

use crate::bus::Bus;
use crate::clock::Clocks;
use crate::interrupts;
use crate::registers::usart;

/// Bits a second: 42 ticks of the bus with the PLL and 16 without, exactly. The 921 600 that hosts often
/// offer would be 0.93 % too slow and 2.1 % too fast (RM0090, 30.3.4).
pub const BAUD: u32 = 1_000_000;

/// Bytes that came and nobody heard yet, and bytes to be said: at least two whole frames, and powers
/// of two, so that a queue masks where it would divide.
const ROOM: usize = 2048;
const _: () = assert!(ROOM > 2 * LONGEST_FRAME);

/// Bytes on their way.
pub type Bytes = Queue<u8, ROOM>;

/// The background's end.
pub struct Line<'a, B> {
    bus: B,
    heard: Consumer<'a, u8, ROOM>,
    to_say: Producer<'a, u8, ROOM>,
}

/// The interrupt's end.
pub struct Port<'a, B> {
    bus: B,
    /// Whether the line calls when it can take a byte.
    is_saying: bool,
    heard: Producer<'a, u8, ROOM>,
    to_say: Consumer<'a, u8, ROOM>,
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
    heard: &'a mut Bytes,
    to_say: &'a mut Bytes,
) -> (Line<'a, B>, Port<'a, B>) {
    let (put_heard, heard) = heard.split();
    let (to_say, take_to_say) = to_say.split();
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
        is_saying: false,
        heard: put_heard,
        to_say: take_to_say,
    };
    (Line { bus, heard, to_say }, port)
}

impl<B> Line<'_, B> {
    /// Whether nothing came that was not heard yet.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.heard.len() == 0
    }
}

impl<B: Bus> drive_link::Line for Line<'_, B> {
    fn hear(&mut self) -> Option<u8> {
        self.heard.dequeue()
    }

    fn room(&self) -> usize {
        self.to_say.capacity() - self.to_say.len()
    }

    fn say(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let _ = self.to_say.enqueue(byte);
        }
        // The interrupt finds something to say.
        interrupts::pend_serial(self.bus);
    }
}

impl<B: Bus> Port<'_, B> {
    /// What the interrupt does.
    pub fn serve(&mut self) {
        let bus = self.bus;
        let status = bus.read(usart::SR);
        // Reading clears an overrun too; a byte that found no room spoils its frame, which says so.
        if status & (usart::SR_RXNE | usart::SR_ORE) != 0 {
            let _ = self.heard.enqueue(bus.read(usart::DR) as u8);
        }
        if status & usart::SR_TXE != 0 {
            match self.to_say.dequeue() {
                Some(byte) => {
                    bus.write(usart::DR, u32::from(byte));
                    if !self.is_saying {
                        self.is_saying = true;
                        bus.modify(usart::CR1, 0, usart::CR1_TXEIE);
                    }
                }
                None => {
                    self.is_saying = false;
                    bus.modify(usart::CR1, usart::CR1_TXEIE, 0);
                }
            }
        }
    }
}
