//! The flash of the STM32F4 and its interface (RM0090, 3).

use crate::shared::model::clocks::Frequencies;
use crate::shared::model::memory::{BASE, Memory};

/// Size of a sector (table 5).
const SECTOR: u32 = 0x4000;

/// Longest time by the data sheet, ns: 0.5 s for such a sector, 100 µs for a word.
const ERASURE: u64 = 500_000_000;
const WORD: u64 = 100_000;

/// Access and control after reset.
pub(crate) const AFTER_RESET: [u32; 2] = [0, 0x8000_0000];
/// Flags of errors with which no step begins.
pub(crate) const ERRORS: u32 = 0;

/// It has nothing of its own.
#[derive(Default)]
pub(crate) struct Own();

impl Own {
    pub(crate) fn was_put(&self, _: u32, _: usize) {}
}

impl Memory {
    pub(crate) fn set_options(&self) {}

    /// It recognises no damage.
    pub(crate) fn has_found_damage(&self) -> bool {
        false
    }

    pub(crate) fn check(&self, _: u32) {}

    /// A register's content after a write.
    pub(crate) fn kept(&self, _: u32, _: u32, word: u32) -> u32 {
        word
    }

    /// At 2.7 V and more, a wait state for each 30 MHz begun (table 10).
    pub(crate) fn check_wait_states(&self, frequencies: Frequencies) {
        let states = f64::from(self.wait_states());
        assert!(
            frequencies.processor <= 30e6 * (states + 1.0),
            "{states} wait states at {} Hz",
            frequencies.processor
        );
    }

    pub(crate) fn write_control(&self, word: u32, now: u64, alone: bool) {
        let flash = &self.flash;
        let before = flash.cr().read();
        flash.set(flash.cr(), word);
        let after = flash.cr().read();
        if after.strt().is_start() {
            assert!(
                after.ser().is_sector_erase()
                    && before.ser().is_sector_erase()
                    && before.snb().bits() == after.snb().bits(),
                "the sector is chosen before the start (3.6.3)"
            );
            assert!(after.psize().is_psize32(), "32 bits at 2.7 V (table 7)");
            assert!(!after.mer().is_mass_erase(), "the program is erased too");
            self.begin(now, ERASURE, alone);
            let number = after.snb().bits();
            self.erased.borrow_mut().push(number);
            let first = (u32::from(number) * SECTOR) as usize;
            self.bytes.borrow_mut()[first..first + SECTOR as usize].fill(0xff);
        }
    }

    pub(crate) fn program(&self, address: u32, word: u32, now: u64, alone: bool) {
        let flash = &self.flash;
        let control = flash.cr().read();
        if control.lock().is_locked() || !control.pg().is_program() {
            // Out of order (3.9.5).
            flash.set(flash.sr(), flash.get(flash.sr()) | 1 << 7);
            assert!(flash.sr().read().pgserr().bit());
            return;
        }
        assert!(
            control.psize().is_psize32(),
            "not of the declared width (3.6.2)"
        );
        self.begin(now, WORD, alone);
        let first = (address - BASE) as usize;
        let mut bytes = self.bytes.borrow_mut();
        for (byte, new) in bytes[first..first + 4].iter_mut().zip(word.to_le_bytes()) {
            *byte &= new;
        }
    }
}
