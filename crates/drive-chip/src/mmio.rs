//! The chip's own bus.

use crate::bus::{Bus, Register, Step};
#[cfg(feature = "emulator")]
use crate::emulated;

/// The bus of the chip that this runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mmio;

impl Bus for Mmio {
    #[inline(always)]
    fn read(self, register: Register) -> u32 {
        #[cfg(feature = "emulator")]
        if let Some(word) = emulated::read(register) {
            return word;
        }
        let place = register.address() as *const u32;
        // SAFETY: a `Register` is a word of the memory map, by its constructor.
        unsafe { place.read_volatile() }
    }

    #[inline(always)]
    fn write(self, register: Register, word: u32) {
        #[cfg(feature = "emulator")]
        if emulated::write(register, word) {
            return;
        }
        let place = register.address() as *mut u32;
        // SAFETY: as above, and none of them is memory that the program uses.
        unsafe { place.write_volatile(word) }
    }

    #[cfg(feature = "emulator")]
    fn levels(self, idr: Register) -> Register {
        emulated::levels(idr)
    }

    #[cfg(feature = "emulator")]
    fn switch(self, bsrr: Register, pin: u32) -> Register {
        emulated::switch(bsrr, pin)
    }

    #[inline(always)]
    fn read_pin(self, levels: Register) -> u32 {
        // SAFETY: as above; where the pins are emulated, a word of memory that is kept for them.
        unsafe { (levels.address() as *const u32).read_volatile() }
    }

    #[inline(always)]
    fn write_pin(self, switch: Register, word: u32) {
        // SAFETY: as above.
        unsafe { (switch.address() as *mut u32).write_volatile(word) }
    }

    #[inline]
    fn alone<R>(self, work: impl FnOnce() -> R) -> R {
        cortex_m::interrupt::free(|_| work())
    }

    #[inline]
    fn do_step(self, step: Step) -> u32 {
        in_memory(step)
    }
}

/// A step of the flash, by code in RAM: while the flash is busy, a processor that fetches from it
/// stands still (RM0090, 3.6), for up to two seconds, and would feed no watchdog. Everything that it
/// calls is inlined.
// SAFETY: the section is copied to memory before `main`, as the values of statics are.
#[unsafe(link_section = ".data.flash_step")]
#[inline(never)]
fn in_memory(step: Step) -> u32 {
    step.run(Mmio)
}
