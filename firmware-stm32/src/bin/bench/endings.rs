//! Ends of a program that drives its output, each of which must disable it. The emulator's host chooses one by the last
//! word of the memory.

use core::hint::black_box;

use cortex_m::peripheral::{NVIC, SCB};
use firmware_stm32::board::{self, Interrupt};
use firmware_stm32::ending::emulated;
use identifier_core::drive::Actuator;

firmware_stm32::give_up_at_every_end!();

/// The last word of the memory, which no static takes.
const CHOICE: *const u32 = 0x2001_fffc as *const u32;

pub(crate) fn run() -> Result<(), &'static str> {
    let (_, mut output) = board::wire().ok_or("it was wired before")?;
    if output.hold(5.0).is_err() || !emulated::drives() {
        return Err("the output is not driven");
    }
    emulated::report_end();
    // SAFETY: it is memory.
    match unsafe { CHOICE.read_volatile() } {
        1 => cortex_m::asm::udf(),
        2 => _ = descend(black_box(1)),
        // An NMI, as the clock's supervision raises it.
        // SAFETY: any word may be written there.
        3 => unsafe { (*SCB::PTR).icsr.write(1 << 31) },
        4 => {
            // SAFETY: nothing relies on its being masked.
            unsafe { NVIC::unmask(Interrupt::SPI3) };
            NVIC::pend(Interrupt::SPI3);
        }
        _ => {}
    }
    cortex_m::asm::isb();
    Err("nothing has ended it")
}

/// Takes more stack than there is.
#[inline(never)]
fn descend(depth: u32) -> u32 {
    let frame = black_box([depth; 256]);
    if depth == 0 {
        return 0;
    }
    let below = descend(depth.wrapping_add(1));
    black_box(frame).iter().fold(below, |sum, word| sum ^ word)
}
