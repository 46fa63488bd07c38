//! A serial line that nobody waits for: an interrupt moves bytes between USART2 and two queues.

use drive_link::LONGEST_FRAME;
use heapless::spsc::{Consumer, Producer, Queue};
use stm32f4xx_hal::pac::{Interrupt, NVIC, USART2};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::clock::Clocks;

/// Bits a second.
pub const BAUD: u32 = 921_600;

/// Bytes that came and nobody heard yet, and bytes to be said: at least two whole frames, and powers
/// of two, so that a queue masks where it would divide.
const ROOM: usize = 2048;
const _: () = assert!(ROOM > 2 * LONGEST_FRAME);

/// Bytes on their way.
pub type Bytes = Queue<u8, ROOM>;

/// The background's end.
pub struct Line<'a> {
    heard: Consumer<'a, u8, ROOM>,
    to_say: Producer<'a, u8, ROOM>,
}

/// The interrupt's end.
pub struct Port<'a> {
    registers: USART2,
    heard: Producer<'a, u8, ROOM>,
    to_say: Consumer<'a, u8, ROOM>,
}

/// Both ends of a line of 8 bits without parity.
#[must_use]
pub fn line<'a>(
    registers: USART2,
    clocks: &Clocks,
    rcc: &mut Rcc,
    heard: &'a mut Bytes,
    to_say: &'a mut Bytes,
) -> (Line<'a>, Port<'a>) {
    let (put_heard, heard) = heard.split();
    let (to_say, take_to_say) = to_say.split();
    USART2::enable(rcc);
    USART2::reset(rcc);
    // Sixteenfold sampling: the divider's four fraction bits are the low ones (RM0090, 30.3.4).
    let divider = ((clocks.low_bus + BAUD / 2) / BAUD) as u16;
    // SAFETY: any divider from 1 on.
    registers
        .brr()
        .write(|write| unsafe { write.bits(divider) });
    registers.cr1().write(|write| {
        let write = write.ue().set_bit().te().set_bit();
        write.re().set_bit().rxneie().set_bit()
    });
    let port = Port {
        registers,
        heard: put_heard,
        to_say: take_to_say,
    };
    (Line { heard, to_say }, port)
}

impl drive_logic::Line for Line<'_> {
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
        NVIC::pend(Interrupt::USART2);
    }
}

impl Port<'_> {
    /// What the interrupt does.
    pub fn serve(&mut self) {
        let status = self.registers.sr().read();
        // Reading clears an overrun too; a byte that found no room spoils its frame, which says so.
        if status.rxne().bit_is_set() || status.ore().bit_is_set() {
            let byte = self.registers.dr().read().dr().bits() as u8;
            let _ = self.heard.enqueue(byte);
        }
        if status.txe().bit_is_set() {
            match self.to_say.dequeue() {
                Some(byte) => {
                    self.registers
                        .dr()
                        .write(|write| write.dr().set(byte.into()));
                    self.registers
                        .cr1()
                        .modify(|_, write| write.txeie().set_bit());
                }
                None => {
                    self.registers
                        .cr1()
                        .modify(|_, write| write.txeie().clear_bit());
                }
            }
        }
    }
}
