//! Two sectors of the chip's flash, where records are kept (RM0090, 3.6).
//!
//! While the flash erases or writes, the processor can fetch nothing from it. So each step runs from
//! RAM, without any interrupt, and feeds the watchdog itself: records are kept only while the servo
//! is disabled.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

use crate::bus::{Bus, Register, Step};
use crate::registers::flash;
use crate::{supply, watchdog};

/// Size of a sector, bytes; in an emulator memory stands in for it.
pub(crate) const SECTOR: u32 = if cfg!(feature = "emulator") {
    0x2000
} else {
    0x4000
};

/// Two neighbouring sectors of 16 KiB, between the vectors and the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sectors {
    first: u32,
}

impl Sectors {
    /// By the number of the first of them, 1 or 2.
    ///
    /// # Panics
    /// Anything else: sector 0 has the vectors, and the program begins in sector 4. In a constant it does
    /// not compile.
    #[must_use]
    pub const fn starting_at(first: u32) -> Self {
        assert!(1 <= first && first <= 2, "two sectors from 1 to 3");
        Self { first }
    }

    /// Their first word: the first four sectors are of 16 KiB each (RM0090, table 5).
    const fn base(self) -> Register {
        Register::at(0x0800_0000 + self.first * 0x4000)
    }
}

/// The two sectors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordFlash<B> {
    bus: B,
    sectors: Sectors,
}

/// Failures of the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FlashError {
    /// Outside the two sectors, or not aligned.
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
    /// Of a chip whose flash nothing else writes.
    pub fn new(bus: B, sectors: Sectors) -> Self {
        Self { bus, sectors }
    }

    fn word_at(self, offset: u32) -> Register {
        self.sectors.base().offset(offset & !0b11)
    }

    fn is_busy(self) -> bool {
        self.bus.read(flash::SR) & flash::SR_BSY != 0
    }

    /// # Errors
    /// A busy flash: writing to it would stall the processor until it is ready (RM0090, 3.9.6).
    fn unlock(self) -> Result<(), FlashError> {
        if self.is_busy() {
            return Err(FlashError::Hardware);
        }
        // Keys that are written while it is unlocked lock it until a reset (RM0090, 3.6.1).
        if self.bus.read(flash::CR) & flash::CR_LOCK != 0 {
            for key in flash::KEYS {
                self.bus.write(flash::KEYR, key);
            }
        }
        // Flags of an earlier error would be taken for one of this step.
        self.bus.write(flash::SR, flash::SR_ENDED);
        Ok(())
    }

    fn lock(self) {
        if self.is_busy() {
            return;
        }
        let bus = self.bus;
        bus.write(flash::CR, flash::CR_LOCK);
        // The caches may hold the old contents; they are reset while they are off (RM0090, 3.5.2).
        let access = bus.read(flash::ACR);
        let off = access & !(flash::ACR_DCEN | flash::ACR_ICEN);
        bus.write(flash::ACR, off);
        bus.write(flash::ACR, off | flash::ACR_DCRST | flash::ACR_ICRST);
        bus.write(flash::ACR, off);
        bus.write(flash::ACR, access);
    }

    fn do_step(self, register: Register, word: u32) -> Result<(), FlashError> {
        // A word that is written below 2.7 V may read back whole, and not for long.
        if supply::is_low(self.bus) {
            return Err(FlashError::SupplyLow);
        }
        let step = Step {
            start: (register, word),
            status: flash::SR,
            busy: flash::SR_BSY,
            meanwhile: watchdog::FOOD,
        };
        let status = self.bus.without_interrupts(|| self.bus.do_step(step));
        if status & (flash::SR_BSY | flash::SR_ERRORS) != 0 {
            Err(FlashError::Hardware)
        } else if supply::is_low(self.bus) {
            Err(FlashError::SupplyLow)
        } else {
            Ok(())
        }
    }

    fn erase_sector(self, number: u32) -> Result<(), FlashError> {
        // The sector is chosen before the start (RM0090, 3.6.3).
        let chosen = flash::CR_PSIZE_32 | flash::CR_SER | number << flash::CR_SNB;
        self.bus.write(flash::CR, chosen);
        self.do_step(flash::CR, chosen | flash::CR_STRT)
    }
}

impl<B: Bus> ErrorType for RecordFlash<B> {
    type Error = FlashError;
}

impl<B: Bus> ReadNorFlash for RecordFlash<B> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(self, offset, bytes.len()).map_err(FlashError::Misplaced)?;
        // Reading a whole sector takes as long as the watchdog's timeout.
        watchdog::feed(self.bus);
        for (place, byte) in (offset..).zip(bytes) {
            let word = self.bus.read(self.word_at(place));
            *byte = (word >> (8 * (place & 0b11))) as u8;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR as usize
    }
}

impl<B: Bus> NorFlash for RecordFlash<B> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError::Misplaced)?;
        self.unlock()?;
        let done = (from / SECTOR..to / SECTOR)
            .try_for_each(|sector| self.erase_sector(self.sectors.first + sector));
        self.lock();
        done
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Misplaced)?;
        self.unlock()?;
        // Words of 32 bits (RM0090, 3.6.2).
        self.bus.write(flash::CR, flash::CR_PSIZE_32 | flash::CR_PG);
        let (words, _) = bytes.as_chunks::<4>();
        let done = (offset..)
            .step_by(4)
            .zip(words)
            .try_for_each(|(place, word)| {
                self.do_step(self.word_at(place), u32::from_le_bytes(*word))
            });
        self.lock();
        done
    }
}
