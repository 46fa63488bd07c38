//! The way to the chip's registers.

/// A word of the chip's memory map: a register, or four bytes of the flash.
///
/// Only this crate makes them, so that a bus reaches nothing but what its drivers use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Register(u32);

impl Register {
    /// At an address that is a multiple of four.
    pub(crate) const fn at(address: u32) -> Self {
        Self(address)
    }

    /// So many bytes further on.
    pub(crate) const fn offset(self, bytes: u32) -> Self {
        Self(self.0.wrapping_add(bytes))
    }

    /// Where it is.
    #[must_use]
    #[inline(always)]
    pub const fn address(self) -> u32 {
        self.0
    }
}

/// What carries words to registers and back, in the order in which they are given.
pub trait Bus: Copy {
    /// Reads a word.
    fn read(self, register: Register) -> u32;

    /// Writes a word.
    fn write(self, register: Register, word: u32);

    /// Clears some bits of a word and then sets some.
    #[inline(always)]
    fn modify(self, register: Register, clear: u32, set: u32) {
        self.write(register, self.read(register) & !clear | set);
    }

    /// The word that holds the levels of a port, from its IDR.
    ///
    /// What a sample reads and writes of pins goes by these three, because a place that is found once
    /// costs a sample nothing.
    #[inline(always)]
    fn levels(self, idr: Register) -> Register {
        idr
    }

    /// The word that sets and resets a pin, from its port's BSRR.
    #[inline(always)]
    fn switch(self, bsrr: Register, _pin: u32) -> Register {
        bsrr
    }

    /// Reads one of these.
    #[inline(always)]
    fn read_pin(self, levels: Register) -> u32 {
        self.read(levels)
    }

    /// Writes one of these.
    #[inline(always)]
    fn write_pin(self, switch: Register, word: u32) {
        self.write(switch, word);
    }

    /// Does something without any interrupt.
    fn alone<R>(self, work: impl FnOnce() -> R) -> R;

    /// Lets the flash do a [`Step`], which must not be done by code that is fetched from the flash,
    /// and answers with the flash's status at its end.
    #[inline(always)]
    fn do_step(self, step: Step) -> u32 {
        step.run(self)
    }
}

pub use crate::flash::Step;
