//! Erasing and writing the flash (RM0090, 3.6).

use super::Stm32F4;
use super::registers::flash;
use crate::bus::Register;
use crate::family::{Bus, Flash, Storage};
use crate::registers::flash::{CR_PG, CR_STRT};

impl<const MEGAHERTZ: u32> Storage for Stm32F4<MEGAHERTZ> {
    const FLASH: Flash = Flash {
        access: flash::ACR,
        keys: flash::KEYR,
        status: flash::SR,
        control: flash::CR,
        errors: flash::SR_ERRORS,
        ended: flash::SR_ENDED,
    };
    /// Words of 32 bits (RM0090, 3.6.2).
    const WRITE_SIZE: usize = 4;
    const RECOGNISES_DAMAGE: bool = false;

    /// Erases a sector.
    fn erase<E>(
        bus: impl Bus<Family = Self>,
        sector: u32,
        mut step: impl FnMut(Register, u32) -> Result<(), E>,
    ) -> Result<(), E> {
        // The sector is chosen before the start (RM0090, 3.6.3).
        let chosen = flash::CR_PSIZE_32 | flash::CR_SER | sector << flash::CR_SNB;
        bus.write(flash::CR, chosen);
        step(flash::CR, chosen | CR_STRT)
    }

    /// Writes words of 32 bits (RM0090, 3.6.2).
    fn program<E>(
        bus: impl Bus<Family = Self>,
        place: Register,
        bytes: &[u8],
        mut step: impl FnMut(Option<(Register, u32)>, (Register, u32)) -> Result<(), E>,
    ) -> Result<(), E> {
        bus.write(flash::CR, flash::CR_PSIZE_32 | CR_PG);
        let (words, _) = bytes.as_chunks::<4>();
        (0..).step_by(4).zip(words).try_for_each(|(offset, word)| {
            step(None, (place.offset(offset), u32::from_le_bytes(*word)))
        })
    }

    /// Its one cause is a failed oscillator.
    fn outlives_nmi(_: impl Bus<Family = Self>) -> bool {
        false
    }
}
