//! The last two sectors of the chip's flash, where records are kept.
//!
//! While the flash erases or writes, the processor stands still: records are kept only while the
//! servo is let go.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_write,
};
use stm32f4xx_hal::pac::FLASH;

/// Where the sectors 10 and 11 begin in the processor's memory; memory.x leaves them free.
const BASE: usize = 0x080c_0000;

/// Bytes of each (RM0090, table 5).
const SECTOR: usize = 0x2_0000;

/// The first one's number.
const FIRST: u8 = 10;

/// The two sectors.
pub struct InternalFlash {
    registers: FLASH,
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

impl InternalFlash {
    /// Turns of a loop that an erasure may take, some seconds.
    const PATIENCE: u32 = 200_000_000;

    /// Of the chip's registers.
    #[must_use]
    pub fn new(registers: FLASH) -> Self {
        Self { registers }
    }

    fn unlock(&self) {
        const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
        for key in KEYS {
            // SAFETY: the keys of RM0090, 3.6.1.
            self.registers
                .keyr()
                .write(|write| unsafe { write.bits(key) });
        }
        // What an earlier error left would be taken for one of this time.
        let _ = self.finish();
    }

    fn lock(&self) {
        self.registers
            .cr()
            .modify(|_, write| write.lock().set_bit());
        // The data cache may hold what was there before; it is reset while it is off (RM0090, 3.5.4).
        let access = self.registers.acr();
        access.modify(|_, write| write.dcen().clear_bit());
        access.modify(|_, write| write.dcrst().set_bit());
        access.modify(|_, write| write.dcrst().clear_bit());
        access.modify(|_, write| write.dcen().set_bit());
    }

    /// Waits for the end of what was begun, and forgets the errors it left.
    fn finish(&self) -> Result<(), FlashError> {
        let busy = || self.registers.sr().read().bsy().bit_is_set();
        let ended = (0..Self::PATIENCE).any(|_| !busy());
        let status = self.registers.sr().read();
        let well = status.pgserr().bit_is_clear()
            && status.pgperr().bit_is_clear()
            && status.pgaerr().bit_is_clear()
            && status.wrperr().bit_is_clear();
        // SAFETY: written ones clear their flags.
        self.registers
            .sr()
            .write(|write| unsafe { write.bits(status.bits()) });
        if ended && well {
            Ok(())
        } else {
            Err(FlashError::Hardware)
        }
    }
}

impl ErrorType for InternalFlash {
    type Error = FlashError;
}

impl ReadNorFlash for InternalFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let offset = offset as usize;
        if offset.saturating_add(bytes.len()) > self.capacity() {
            return Err(FlashError::Misplaced(NorFlashErrorKind::OutOfBounds));
        }
        for (k, byte) in bytes.iter_mut().enumerate() {
            let place = (BASE + offset + k) as *const u8;
            // SAFETY: inside the two sectors, by the check above.
            *byte = unsafe { place.read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR
    }
}

impl NorFlash for InternalFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError::Misplaced)?;
        self.unlock();
        let mut done = Ok(());
        for sector in from as usize / SECTOR..to as usize / SECTOR {
            // SAFETY: sectors 10 and 11, by the check above; words of 32 bits (RM0090, 3.6.3).
            self.registers.cr().write(|write| unsafe {
                // A write begins from the reset value, which is locked.
                let write = write.lock().clear_bit().ser().set_bit().psize().psize32();
                write.snb().bits(FIRST + sector as u8).strt().set_bit()
            });
            done = done.and(self.finish());
        }
        self.lock();
        done
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Misplaced)?;
        self.unlock();
        self.registers
            .cr()
            .write(|write| write.lock().clear_bit().pg().set_bit().psize().psize32());
        let mut done = Ok(());
        let (words, _) = bytes.as_chunks::<4>();
        for (k, word) in words.iter().enumerate() {
            let place = (BASE + offset as usize + 4 * k) as *mut u32;
            // SAFETY: inside the two sectors and aligned, by the check above.
            unsafe { place.write_volatile(u32::from_le_bytes(*word)) };
            done = done.and(self.finish());
        }
        self.registers
            .cr()
            .modify(|_, write| write.pg().clear_bit());
        self.lock();
        done
    }
}
