//! Two areas of the chip's flash, where records are kept (RM0090, 3.6; RM0440, FLASH).
//!
//! While the flash erases or writes, the processor can fetch nothing from it. So each step runs from RAM, without any
//! interrupt, and feeds the watchdog itself. Records are kept only while the servo is disabled.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

use crate::bus::{Register, Step};
use crate::family::{Bus, Storage};
use crate::registers::flash::{self, AREA};
use crate::{supply, watchdog};

/// Two neighbouring areas of 16 KiB, between the vectors and the program: sectors of an STM32F4, pages of an STM32G4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Areas {
    first: u32,
}

impl Areas {
    /// By the number of the first of them, 1 or 2.
    ///
    /// # Panics
    /// Anything else: area 0 has the vectors, and the program begins in area 4. In a constant it does
    /// not compile.
    #[must_use]
    pub const fn starting_at(first: u32) -> Self {
        assert!(1 <= first && first <= 2, "two areas from 1 to 3");
        Self { first }
    }

    /// Their first word: an STM32F4's first four sectors are of 16 KiB each (RM0090, table 5).
    const fn base(self) -> Register {
        Register::at(0x0800_0000 + self.first * 0x4000)
    }
}

/// The two areas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordFlash<B> {
    bus: B,
    areas: Areas,
}

/// Failures of the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FlashError {
    /// Outside the two areas, or not aligned.
    Misplaced(NorFlashErrorKind),
    /// The hardware refused, or did not become ready.
    Hardware,
    /// The supply is too low for a step.
    SupplyLow,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Misplaced(kind) => *kind,
            Self::Hardware | Self::SupplyLow => NorFlashErrorKind::Other,
        }
    }
}

impl<B: Bus> RecordFlash<B> {
    /// For a chip whose flash nothing else writes.
    pub fn new(bus: B, areas: Areas) -> Self {
        Self { bus, areas }
    }

    /// The word that has a byte.
    fn word_at(self, offset: u32) -> Register {
        self.areas.base().offset(offset & !0b11)
    }

    #[inline]
    fn read_words(self, offset: u32, bytes: &mut [u8]) {
        for (place, byte) in (offset..).zip(bytes) {
            let word = self.bus.read(self.word_at(place));
            *byte = (word >> (8 * (place & 0b11))) as u8;
        }
    }

    fn is_busy(self) -> bool {
        self.bus.read(B::Family::FLASH.status) & flash::SR_BSY != 0
    }

    /// # Errors
    /// A busy flash: writing to it would stall the processor until it is ready (RM0090, 3.9.6).
    fn unlock(self) -> Result<(), FlashError> {
        if self.is_busy() {
            return Err(FlashError::Hardware);
        }
        // Keys that are written while it is unlocked lock it until a reset (RM0090, 3.6.1).
        if self.bus.read(B::Family::FLASH.control) & flash::CR_LOCK != 0 {
            for key in flash::KEYS {
                self.bus.write(B::Family::FLASH.keys, key);
            }
        }
        // Flags of an earlier error would be taken for one of this step.
        self.bus
            .write(B::Family::FLASH.status, B::Family::FLASH.ended);
        Ok(())
    }

    fn lock(self) {
        if self.is_busy() {
            return;
        }
        let (bus, registers) = (self.bus, B::Family::FLASH);
        bus.write(registers.control, flash::CR_LOCK);
        // The caches may hold the old contents; they are reset while they are off (RM0090, 3.5.2).
        let access = bus.read(registers.access);
        let off = access & !(flash::ACR_DCEN | flash::ACR_ICEN);
        bus.write(registers.access, off);
        bus.write(registers.access, off | flash::ACR_DCRST | flash::ACR_ICRST);
        bus.write(registers.access, off);
        bus.write(registers.access, access);
    }

    /// Does a step that a word starts, or two.
    fn do_step(
        self,
        first: Option<(Register, u32)>,
        start: (Register, u32),
    ) -> Result<(), FlashError> {
        // A word that is written below 2.7 V may read back whole, and not for long.
        if supply::has_sagged(self.bus) {
            return Err(FlashError::SupplyLow);
        }
        let step = Step {
            start,
            status: B::Family::FLASH.status,
            busy: flash::SR_BSY,
            meanwhile: watchdog::FOOD,
        };
        // A sag is looked for before a sample acknowledges it.
        let (status, has_sagged) = self.bus.without_interrupts(|| {
            if let Some((register, word)) = first {
                self.bus.write(register, word);
            }
            (self.bus.do_step(step), supply::has_sagged(self.bus))
        });
        if status & (flash::SR_BSY | B::Family::FLASH.errors) != 0 {
            Err(FlashError::Hardware)
        } else if has_sagged {
            Err(FlashError::SupplyLow)
        } else {
            Ok(())
        }
    }
}

impl<B: Bus> ErrorType for RecordFlash<B> {
    type Error = FlashError;
}

impl<B: Bus> ReadNorFlash for RecordFlash<B> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(self, offset, bytes.len()).map_err(FlashError::Misplaced)?;
        // Reading a whole area takes as long as the watchdog's timeout.
        watchdog::feed(self.bus);
        if !B::Family::RECOGNISES_DAMAGE {
            self.read_words(offset, bytes);
        } else if !(self.bus.damage()).survive(|| self.read_words(offset, bytes)) {
            return Err(FlashError::Hardware);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * AREA as usize
    }
}

impl<B: Bus> NorFlash for RecordFlash<B> {
    const WRITE_SIZE: usize = B::Family::WRITE_SIZE;
    const ERASE_SIZE: usize = AREA as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError::Misplaced)?;
        self.unlock()?;
        let done = (from / AREA..to / AREA).try_for_each(|area| {
            let area = self.areas.first + area;
            B::Family::erase(self.bus, area, |register, word| {
                self.do_step(None, (register, word))
            })
        });
        self.lock();
        done
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Misplaced)?;
        self.unlock()?;
        let done = B::Family::program(self.bus, self.word_at(offset), bytes, |first, last| {
            self.do_step(first, last)
        });
        self.lock();
        done
    }
}
