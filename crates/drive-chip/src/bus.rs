//! Words of the chip's memory map, and what is done with them.

use core::sync::atomic::{AtomicBool, Ordering};

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

/// Damage of the flash, on its way from the interrupt that finds it to the program that reads.
#[derive(Debug)]
pub struct Damage {
    is_expected: AtomicBool,
    is_found: AtomicBool,
}

impl Damage {
    /// Neither expected nor found.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            is_expected: AtomicBool::new(false),
            is_found: AtomicBool::new(false),
        }
    }

    /// Reads words that may be damaged; true if they were whole.
    pub(crate) fn survive(&self, read: impl FnOnce()) -> bool {
        self.is_found.store(false, Ordering::Relaxed);
        self.is_expected.store(true, Ordering::SeqCst);
        read();
        self.is_expected.store(false, Ordering::SeqCst);
        !self.is_found.load(Ordering::Relaxed)
    }

    /// Reports damage from the interrupt; false if it is none of words that may be damaged.
    pub(crate) fn report(&self) -> bool {
        let is_expected = self.is_expected.load(Ordering::SeqCst);
        self.is_found.store(is_expected, Ordering::Relaxed);
        is_expected
    }
}

impl Default for Damage {
    fn default() -> Self {
        Self::new()
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
    pub(crate) const MAX_READS: u32 = 40_000_000;
}
