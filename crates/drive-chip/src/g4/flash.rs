//! Erasing and writing the flash, and words in it that a loss of power has damaged (RM0440, FLASH).

use super::G4;
use super::registers::{flash, rcc};
use crate::bus::Register;
use crate::family::{Bus, Flash, Storage};
use crate::registers::flash::{AREA, CR_PG, CR_STRT, SR_BSY};

/// Size of a page of two banks, bytes, and of one bank (RM0440, FLASH).
const PAGE_OF_TWO: u32 = 0x800;
const PAGE_OF_ONE: u32 = 0x1000;

impl Storage for G4 {
    const FLASH: Flash = Flash {
        access: flash::ACR,
        keys: flash::KEYR,
        status: flash::SR,
        control: flash::CR,
        errors: flash::SR_ERRORS,
        ended: flash::SR_ENDED,
    };
    /// Double words of 64 bits (RM0440, FLASH).
    const WRITE_SIZE: usize = 8;
    const RECOGNISES_DAMAGE: bool = true;

    /// Erases an area, page by page. It lies within the first bank, if there are two.
    fn erase<E>(
        bus: impl Bus<Family = Self>,
        area: u32,
        mut step: impl FnMut(Register, u32) -> Result<(), E>,
    ) -> Result<(), E> {
        let page = if bus.read(flash::OPTR) & flash::OPTR_DBANK == 0 {
            PAGE_OF_ONE
        } else {
            PAGE_OF_TWO
        };
        let pages = AREA / page;
        (area * pages..(area + 1) * pages).try_for_each(|page| {
            // The page is chosen before the start (RM0440, FLASH).
            let chosen = flash::CR_PER | page << flash::CR_PNB;
            bus.write(flash::CR, chosen);
            step(flash::CR, chosen | CR_STRT)
        })
    }

    /// Writes double words of 64 bits (RM0440, FLASH). One that reads as blank and was not erased, as after an
    /// interrupted write, can only be zeroed. It then no longer reads as blank, and the next record skips it.
    fn program<E>(
        bus: impl Bus<Family = Self>,
        place: Register,
        bytes: &[u8],
        mut step: impl FnMut(Option<(Register, u32)>, (Register, u32)) -> Result<(), E>,
    ) -> Result<(), E> {
        bus.write(flash::CR, CR_PG);
        let (words, _) = bytes.as_chunks::<8>();
        (0..)
            .step_by(8)
            .zip(words)
            .try_for_each(|(offset, &[a, b, c, d, e, f, g, h])| {
                let place = place.offset(offset);
                let mut write = |low, high| step(Some((place, low)), (place.offset(4), high));
                let written = write(
                    u32::from_le_bytes([a, b, c, d]),
                    u32::from_le_bytes([e, f, g, h]),
                );
                if written.is_err() && bus.read(flash::SR) & SR_BSY == 0 {
                    // Its flag would be taken for an error of the next step.
                    bus.write(flash::SR, flash::SR_ENDED);
                    let _ = write(0, 0);
                }
                written
            })
    }

    /// The causes are a failed oscillator, and two wrong bits in a double word of the flash. The word is of the
    /// program, or of a record that was being written at a loss of power.
    fn outlives_nmi(bus: impl Bus<Family = Self>) -> bool {
        let has_failed = bus.read(rcc::CIFR) & rcc::CIFR_CSSF != 0;
        let is_damaged = bus.read(flash::ECCR) & flash::ECCR_DAMAGED != 0;
        if has_failed || !is_damaged || !bus.damage().report() {
            return false;
        }
        // Ones clear.
        bus.write(flash::ECCR, flash::ECCR_DAMAGED);
        true
    }
}
