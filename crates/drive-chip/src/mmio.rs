//! The chip's own bus.

use core::marker::PhantomData;

use crate::bus::{Damage, Register, Step};
#[cfg(feature = "emulator")]
use crate::emulated;
use crate::family::{self, Bus, Family};

/// The memory bus of the chip itself, of a family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mmio<F>(PhantomData<F>);

impl<F: Family> Mmio<F> {
    /// The bus of the chip that runs the program.
    pub const BUS: Self = Self(PhantomData);
}

impl<F: Family> Bus for Mmio<F> {
    type Family = F;

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
        #[cfg(feature = "emulator")]
        let word = emulated::stretched(register, word);
        let place = register.address() as *mut u32;
        // SAFETY: as above, and none of them is memory that the program uses.
        unsafe { place.write_volatile(word) }
    }

    #[cfg(feature = "emulator")]
    fn pin_word(self, register: Register, pin: u32) -> Register {
        emulated::pin_word(register, pin)
    }

    #[inline(always)]
    fn read_pin(self, word: Register) -> u32 {
        // SAFETY: as above; where the pins are emulated, a word of memory that stands in for them.
        unsafe { (word.address() as *const u32).read_volatile() }
    }

    #[inline(always)]
    fn write_pin(self, word: Register, levels: u32) {
        // SAFETY: as above.
        unsafe { (word.address() as *mut u32).write_volatile(levels) }
    }

    #[inline]
    fn take_interrupts(self) {
        // The write that made one pending is complete, and nothing after it was fetched (PM0214, 2.2.4).
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }

    #[inline]
    fn without_interrupts<R>(self, work: impl FnOnce() -> R) -> R {
        cortex_m::interrupt::free(|_| work())
    }

    #[inline]
    fn damage(self) -> &'static Damage {
        static DAMAGE: Damage = Damage::new();
        &DAMAGE
    }

    #[inline]
    fn do_step(self, step: Step) -> u32 {
        from_ram::<F>(step)
    }
}

/// A step of the flash, by code in RAM. A processor that fetches from a busy flash stalls for up to two seconds
/// (RM0090, 3.6) and would not feed the watchdog. Everything that it calls is inlined.
// SAFETY: the section is copied to RAM before `main`, as the values of statics are.
#[unsafe(link_section = ".data.flash_step")]
#[inline(never)]
fn from_ram<F: Family>(step: Step) -> u32 {
    family::do_step(Mmio::<F>::BUS, step)
}
