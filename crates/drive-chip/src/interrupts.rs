//! Interrupt priorities (PM0214, 4.3): a sample preempts everything, the line only the background.

use crate::family::Bus;
use crate::registers::{nvic, scb};

/// Positions in the vector table, the same in both families (RM0090, table 61; RM0440, NVIC).
const TIM5: u32 = 50;
const PVD: u32 = 1;
const USART2: u32 = 38;

/// Above everything else.
const SAMPLE: u32 = 0x00;

/// Below every sample. Its timer has the same, so that one waits for the other.
const LINE: u32 = 0x80;

/// Enables the interrupts of the sample timer, the supply's detector and the serial line, once their handlers have their data.
pub fn begin(bus: impl Bus) {
    set_priority(bus, TIM5, SAMPLE);
    // With the samples, so that none of them is interrupted and then drives the output again.
    set_priority(bus, PVD, SAMPLE);
    begin_serial(bus);
    unmask(bus, PVD);
    unmask(bus, TIM5);
}

/// Enables the serial line's interrupt alone.
pub fn begin_serial(bus: impl Bus) {
    set_priority(bus, USART2, LINE);
    bus.modify(
        scb::SHPR3,
        0xff << scb::SHPR3_SYSTICK,
        LINE << scb::SHPR3_SYSTICK,
    );
    unmask(bus, USART2);
}

/// Requests the serial line's interrupt.
#[inline]
pub fn pend_serial(bus: impl Bus) {
    bus.write(nvic::ISPR.offset(word(USART2)), bit(USART2));
}

fn set_priority(bus: impl Bus, interrupt: u32, priority: u32) {
    let shift = 8 * (interrupt & 0b11);
    let register = nvic::IPR.offset(interrupt & !0b11);
    bus.modify(register, 0xff << shift, priority << shift);
}

/// Zeros do not change the others.
fn unmask(bus: impl Bus, interrupt: u32) {
    bus.write(nvic::ISER.offset(word(interrupt)), bit(interrupt));
}

/// Offset of the word with an interrupt's bit, bytes.
const fn word(interrupt: u32) -> u32 {
    (interrupt / 32) << 2
}

const fn bit(interrupt: u32) -> u32 {
    1 << (interrupt % 32)
}
