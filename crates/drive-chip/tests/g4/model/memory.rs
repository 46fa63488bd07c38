//! The flash of the STM32G4 and its interface (RM0440, FLASH).

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

use crate::shared::model::clocks::Frequencies;
use crate::shared::model::memory::{BASE, Memory};

/// Longest time by the data sheet, ns: 24.5 ms for a page, 91 µs for a double word.
const ERASURE: u64 = 24_500_000;
const DOUBLE_WORD: u64 = 91_000;

/// Access and control after reset.
pub(crate) const AFTER_RESET: [u32; 2] = [0x0004_0600, 0xc000_0000];
/// Flags of errors with which no step begins.
pub(crate) const ERRORS: u32 = 0xc3fa;

#[derive(Default)]
pub(crate) struct Own {
    /// Double words that were written since they were erased.
    written: RefCell<BTreeSet<u32>>,
    /// Those of them whose bits do not fit their check: a loss of power has damaged them.
    damaged: RefCell<BTreeSet<u32>>,
    /// The first half of a double word, and its address.
    half: Cell<Option<(u32, u32)>>,
}

impl Own {
    pub(crate) fn was_put(&self, address: u32, length: usize) {
        let places = (address..).step_by(8).take(length / 8);
        self.written.borrow_mut().extend(places);
    }
}

impl Memory {
    /// As delivered.
    pub(crate) fn set_options(&self) {
        self.flash.set(self.flash.optr(), 0xffef_f8aa);
    }

    /// Looks at the check of a word that is read.
    pub(crate) fn check(&self, address: u32) {
        let flash = &self.flash;
        if self.own.damaged.borrow().contains(&(address & !0b111)) {
            flash.set(flash.eccr(), flash.get(flash.eccr()) | 1 << 31);
            assert!(flash.eccr().read().eccd().bit());
        }
    }

    /// A register's content after a write: ones clear the flags of the check.
    pub(crate) fn kept(&self, address: u32, before: u32, word: u32) -> u32 {
        if address == self.flash.address(self.flash.eccr()) {
            before & !(word & 0xf000_0000)
        } else {
            word
        }
    }

    /// Damages a double word, as a loss of power while it was written does.
    pub(crate) fn damage(&self, address: u32) {
        self.own.written.borrow_mut().insert(address);
        self.own.damaged.borrow_mut().insert(address);
    }

    /// Has a double word read as blank although it was written.
    pub(crate) fn write_blank(&self, address: u32) {
        self.own.written.borrow_mut().insert(address);
    }

    /// True if the flash asks for the interrupt that nothing masks.
    pub(crate) fn has_found_damage(&self) -> bool {
        let check = self.flash.eccr().read();
        check.eccd().bit() || check.eccd2().bit()
    }

    /// A wait state for each 34 MHz begun with the boost, which everything beyond 150 MHz has (FLASH); without it for each
    /// 30 MHz.
    pub(crate) fn check_wait_states(&self, frequencies: Frequencies) {
        let states = f64::from(self.wait_states());
        let each = if frequencies.processor > 150e6 {
            34e6
        } else {
            30e6
        };
        assert!(
            frequencies.processor <= each * (states + 1.0),
            "{states} wait states at {} Hz",
            frequencies.processor
        );
    }

    /// Size of a page, bytes (FLASH).
    fn page(&self) -> u32 {
        if self.flash.optr().read().dbank().bit() {
            0x800
        } else {
            0x1000
        }
    }

    pub(crate) fn write_control(&self, word: u32, now: u64, alone: bool) {
        let flash = &self.flash;
        assert_eq!(self.own.half.get(), None, "half a double word was written");
        let before = flash.cr().read();
        flash.set(flash.cr(), word);
        let after = flash.cr().read();
        if after.strt().bit() {
            assert!(
                after.per().bit()
                    && before.per().bit()
                    && before.pnb().bits() == after.pnb().bits()
                    && !after.bker().bit()
                    && !after.pg().bit(),
                "the page of the first bank is chosen before the start (FLASH)"
            );
            assert!(!after.mer1().bit() && !after.mer2().bit(), "everything");
            let number = after.pnb().bits();
            if !self.begin(now, ERASURE, alone) {
                return;
            }
            self.erased.borrow_mut().push(number);
            let page = self.page();
            let (first, last) = (u32::from(number) * page, (u32::from(number) + 1) * page);
            self.bytes.borrow_mut()[first as usize..last as usize].fill(0xff);
            let stays = |place: &u32| !(BASE + first..BASE + last).contains(place);
            self.own.written.borrow_mut().retain(stays);
            self.own.damaged.borrow_mut().retain(stays);
        }
    }

    /// Halves of a double word, in their order (FLASH).
    pub(crate) fn program(&self, address: u32, word: u32, now: u64, alone: bool) {
        let flash = &self.flash;
        let control = flash.cr().read();
        assert!(
            !control.lock().bit() && control.pg().bit() && !control.fstpg().bit(),
            "out of order (FLASH)"
        );
        assert!(alone, "an interrupt between the halves");
        let Some((place, low)) = self.own.half.take() else {
            assert_eq!(address % 8, 0, "the first half is the lower one");
            self.own.half.set(Some((address, word)));
            return;
        };
        assert_eq!(address, place + 4, "the halves belong together");
        if !self.begin(now, DOUBLE_WORD, alone) {
            return;
        }
        let is_erased = !self.own.written.borrow().contains(&place);
        if !is_erased && (low, word) != (0, 0) {
            flash.set(flash.sr(), flash.get(flash.sr()) | 1 << 3);
            assert!(flash.sr().read().progerr().bit());
            return;
        }
        let first = (place - BASE) as usize;
        let mut bytes = self.bytes.borrow_mut();
        bytes[first..first + 4].copy_from_slice(&low.to_le_bytes());
        bytes[first + 4..first + 8].copy_from_slice(&word.to_le_bytes());
        self.own.written.borrow_mut().insert(place);
        self.own.damaged.borrow_mut().remove(&place);
    }
}
