//! Access to the chip's registers.

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

    /// The word at an offset from this one, bytes.
    pub(crate) const fn offset(self, bytes: u32) -> Self {
        Self(self.0.wrapping_add(bytes))
    }

    /// Its address.
    #[must_use]
    #[inline(always)]
    pub const fn address(self) -> u32 {
        self.0
    }
}

/// Carries words to registers and back, in the order in which they are given.
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

    /// The word in which [`Bus::read_pin`] and [`Bus::write_pin`] find a pin, from the IDR or BSRR of
    /// its port: looked up once, it costs a sample nothing.
    #[inline(always)]
    fn pin_word(self, register: Register, _pin: u32) -> Register {
        register
    }

    /// Reads a pin's word.
    #[inline(always)]
    fn read_pin(self, word: Register) -> u32 {
        self.read(word)
    }

    /// Writes a pin's word.
    #[inline(always)]
    fn write_pin(self, word: Register, levels: u32) {
        self.write(word, levels);
    }

    /// Has every interrupt that is pending be served before what follows.
    fn take_interrupts(self);

    /// Does something without any interrupt.
    fn without_interrupts<R>(self, work: impl FnOnce() -> R) -> R;

    /// Does a [`Step`], by code that is not fetched from the flash, and returns the status at its end.
    #[inline(always)]
    fn do_step(self, step: Step) -> u32 {
        step.run(self)
    }
}

/// A step of the flash: a word that starts it, and how to wait for its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// The word that starts it, and where it is written.
    pub(crate) start: (Register, u32),
    /// The register that is read until the step has ended.
    pub(crate) status: Register,
    /// Bits of the status that are set until then.
    pub(crate) busy: u32,
    /// Written before every read of the status.
    pub(crate) meanwhile: (Register, u32),
}

impl Step {
    /// Reads of the status, several seconds: an erasure takes at most half of one.
    const MAX_READS: u32 = 40_000_000;

    /// Does it and returns the status at its end.
    #[inline(always)]
    pub(crate) fn run(self, bus: impl Bus) -> u32 {
        let write = |(register, word)| bus.write(register, word);
        write(self.start);
        let mut reads_left = Self::MAX_READS;
        loop {
            write(self.meanwhile);
            let status = bus.read(self.status);
            if status & self.busy == 0 || reads_left == 0 {
                return status;
            }
            reads_left -= 1;
        }
    }
}
