//! Two sectors of the chip's flash, where records are kept (RM0090, 3.6).
//!
//! While the flash erases or writes, the processor can fetch nothing from it. So each step runs from
//! RAM, without any interrupt, and feeds the watchdog itself: records are kept only while the servo
//! is let go.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

use crate::bus::{Bus, Register};
use crate::registers::flash;
use crate::watchdog;

/// Bytes of a sector; those that stand in for it in an emulator are fewer.
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
    /// By the number of the first of them.
    ///
    /// # Panics
    /// 1 or 2: sector 0 has the vectors, and with sector 4 the program begins; made as a constant, anything
    /// else does not compile.
    #[must_use]
    pub const fn from(first: u32) -> Self {
        assert!(1 <= first && first <= 2, "two sectors from 1 to 3");
        Self { first }
    }

    /// Where they begin: the first four are of 16 KiB each (RM0090, table 5).
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

/// Why the flash did not do it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FlashError {
    /// Outside the two sectors, or not at the boundary that it takes.
    Misplaced(NorFlashErrorKind),
    /// The hardware refused, or did not become ready.
    Hardware,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Misplaced(kind) => *kind,
            Self::Hardware => NorFlashErrorKind::Other,
        }
    }
}

/// What the flash does in one go: a word that is written, and the time until it is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    register: Register,
    word: u32,
}

impl Step {
    /// Turns of a loop that it may take, several seconds: an erasure takes half of one at most.
    const TURNS: u32 = 40_000_000;

    /// Does it and answers with the flash's status at its end.
    #[inline(always)]
    pub(crate) fn run(self, bus: impl Bus) -> u32 {
        bus.write(self.register, self.word);
        let mut turns = Self::TURNS;
        loop {
            watchdog::feed(bus);
            let status = bus.read(flash::SR);
            if status & flash::SR_BSY == 0 || turns == 0 {
                return status;
            }
            turns -= 1;
        }
    }
}

impl<B: Bus> RecordFlash<B> {
    pub(crate) fn new(bus: B, sectors: Sectors) -> Self {
        Self { bus, sectors }
    }

    fn place(self, offset: u32) -> Register {
        self.sectors.base().offset(offset & !0b11)
    }

    fn is_busy(self) -> bool {
        self.bus.read(flash::SR) & flash::SR_BSY != 0
    }

    /// # Errors
    /// A flash that is busy for ever would hold for ever whoever writes to it (RM0090, 3.9.6).
    fn unlock(self) -> Result<(), FlashError> {
        if self.is_busy() {
            return Err(FlashError::Hardware);
        }
        // Keys that come when it is open would close it until a reset (RM0090, 3.6.1).
        if self.bus.read(flash::CR) & flash::CR_LOCK != 0 {
            for key in flash::KEYS {
                self.bus.write(flash::KEYR, key);
            }
        }
        // What an earlier error left would be taken for one of this time.
        self.bus.write(flash::SR, flash::SR_ENDED);
        Ok(())
    }

    fn lock(self) {
        if self.is_busy() {
            return;
        }
        let bus = self.bus;
        bus.write(flash::CR, flash::CR_LOCK);
        // The caches may hold what was there before; they are reset while they are off (RM0090,
        // 3.5.2).
        let access = bus.read(flash::ACR);
        let off = access & !(flash::ACR_DCEN | flash::ACR_ICEN);
        bus.write(flash::ACR, off);
        bus.write(flash::ACR, off | flash::ACR_DCRST | flash::ACR_ICRST);
        bus.write(flash::ACR, off);
        bus.write(flash::ACR, access);
    }

    fn do_step(self, register: Register, word: u32) -> Result<(), FlashError> {
        let step = Step { register, word };
        let status = self.bus.alone(|| self.bus.do_step(step));
        if status & (flash::SR_BSY | flash::SR_ERRORS) == 0 {
            Ok(())
        } else {
            Err(FlashError::Hardware)
        }
    }

    fn erase_sector(self, number: u32) -> Result<(), FlashError> {
        // Which sector is said before it starts (RM0090, 3.6.3).
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
        // A search through a whole sector takes as long as the watchdog waits.
        watchdog::feed(self.bus);
        for (place, byte) in (offset..).zip(bytes) {
            let word = self.bus.read(self.place(place));
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
                self.do_step(self.place(place), u32::from_le_bytes(*word))
            });
        self.lock();
        done
    }
}
