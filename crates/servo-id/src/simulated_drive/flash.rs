use core::convert::Infallible;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Two sectors of a flash that never fails and that is gone with the program.
#[derive(Debug, Clone)]
pub struct FlashInMemory(Vec<u8>);

impl FlashInMemory {
    /// The flash in its factory state.
    #[must_use]
    pub fn erased() -> Self {
        Self(vec![0xff; 2 * Self::ERASE_SIZE])
    }
}

impl ErrorType for FlashInMemory {
    type Error = Infallible;
}

impl ReadNorFlash for FlashInMemory {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        let kept = self.0.iter().skip(offset as usize);
        for (byte, kept) in bytes.iter_mut().zip(kept) {
            *byte = *kept;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for FlashInMemory {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 16_384;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
        let length = to.saturating_sub(from) as usize;
        let sectors = self.0.iter_mut().skip(from as usize).take(length);
        sectors.for_each(|byte| *byte = 0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        // A bit that is written becomes zero; only erasing makes it one again.
        let places = self.0.iter_mut().skip(offset as usize);
        for (place, byte) in places.zip(bytes) {
            *place &= byte;
        }
        Ok(())
    }
}
