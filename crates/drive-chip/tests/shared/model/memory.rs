//! The flash and its interface: what both families have (RM0090, 3; RM0440, FLASH).

use std::cell::{Cell, RefCell};

use super::block::Block;
use crate::model::memory::{AFTER_RESET, ERRORS, Own};
use crate::pac::{FLASH, flash};

/// Where the areas of the program's vectors and of the records begin and end.
pub(crate) const BASE: u32 = 0x0800_0000;
pub(crate) const END: u32 = 0x0801_0000;

pub(crate) struct Memory {
    pub(crate) flash: Block<flash::RegisterBlock>,
    pub(crate) bytes: RefCell<Vec<u8>>,
    /// The data and the instruction cache may hold contents from before the last step.
    stale: [Cell<bool>; 2],
    keys: Cell<Keys>,
    busy_until: Cell<u64>,
    /// Errors of the next step, as bits of the status.
    pub(crate) fails: Cell<u32>,
    /// A step never ends.
    pub(crate) hangs: Cell<bool>,
    /// Times that the status was read since something was written.
    asked: Cell<u64>,
    /// The same while nothing was done.
    idle: Cell<u32>,
    /// Sectors or pages that were erased.
    pub(crate) erased: RefCell<Vec<u8>>,
    pub(crate) own: Own,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Keys {
    None,
    First,
    /// A wrong one: nothing helps before a reset (RM0090, 3.6.1).
    Wrong,
}

impl Memory {
    pub(crate) fn new() -> Self {
        let flash = Block::at(FLASH::ptr());
        let [access, control] = AFTER_RESET;
        flash.set(flash.acr(), access);
        flash.set(flash.cr(), control);
        let memory = Self {
            flash,
            bytes: RefCell::new(vec![0xff; (END - BASE) as usize]),
            stale: Default::default(),
            keys: Cell::new(Keys::None),
            busy_until: Cell::new(0),
            fails: Cell::new(0),
            hangs: Cell::new(false),
            asked: Cell::new(0),
            idle: Cell::new(0),
            erased: RefCell::default(),
            own: Own::default(),
        };
        memory.set_options();
        memory
    }

    /// The content of the flash itself, past any cache.
    pub(crate) fn bytes(&self, address: u32, length: usize) -> Vec<u8> {
        let first = (address - BASE) as usize;
        self.bytes.borrow()[first..first + length].to_vec()
    }

    /// Puts bytes there, as an earlier program did: on a G4 whole double words.
    pub(crate) fn put(&self, address: u32, bytes: &[u8]) {
        let first = (address - BASE) as usize;
        self.bytes.borrow_mut()[first..first + bytes.len()].copy_from_slice(bytes);
        self.own.was_put(address, bytes.len());
    }

    pub(crate) fn is_locked(&self) -> bool {
        self.flash.cr().read().lock().bit()
    }

    /// True if both caches and the prefetch are on.
    pub(crate) fn is_cached(&self) -> bool {
        let access = self.flash.acr().read();
        access.dcen().bit() && access.icen().bit() && access.prften().bit()
    }

    pub(crate) fn is_stale(&self) -> bool {
        self.stale.iter().any(Cell::get)
    }

    /// The wait states in force.
    pub(crate) fn wait_states(&self) -> u8 {
        self.flash.acr().read().latency().bits()
    }

    /// True while it erases or writes.
    pub(crate) fn is_in_a_step(&self, now: u64) -> bool {
        now < self.busy_until.get()
    }

    pub(crate) fn assert_free(&self, now: u64) {
        assert!(!self.is_in_a_step(now), "the flash is busy (RM0090, 3.6)");
    }

    fn status(&self, now: u64) -> u32 {
        let flash = &self.flash;
        let busy = self.is_in_a_step(now);
        let asked = self.asked.get() + 1;
        self.asked.set(asked);
        assert!(asked < 100_000_000, "the wait has no end");
        if !busy {
            self.asked.set(0);
            let idle = self.idle.get() + 1;
            self.idle.set(idle);
            assert!(idle < 10, "the end of the wait is not seen");
            // The start clears itself with the end (RM0090, 3.9.6).
            flash.set(flash.cr(), flash.get(flash.cr()) & !(1 << 16));
        }
        flash.get(flash.sr()) | u32::from(busy) << 16
    }

    pub(crate) fn read(&self, address: u32, now: u64) -> Option<u32> {
        let flash = &self.flash;
        if address == flash.address(flash.sr()) {
            return Some(self.status(now));
        }
        if (BASE..END).contains(&address) {
            self.assert_free(now);
            let is_cached = flash.acr().read().dcen().bit();
            assert!(
                !is_cached || !self.stale[0].get(),
                "read from a stale cache"
            );
            self.check(address);
            let first = (address - BASE) as usize;
            let bytes = self.bytes.borrow()[first..first + 4].try_into();
            return bytes.ok().map(u32::from_le_bytes);
        }
        flash.word(address).map(Cell::get)
    }

    pub(crate) fn write(&self, address: u32, word: u32, now: u64, alone: bool) -> bool {
        let flash = &self.flash;
        self.asked.set(0);
        self.idle.set(0);
        if (BASE..END).contains(&address) {
            self.program(address, word, now, alone);
            return true;
        }
        let Some(place) = flash.word(address) else {
            return false;
        };
        if address == flash.address(flash.keyr()) {
            self.key(word);
        } else if address == flash.address(flash.sr()) {
            // Ones clear.
            place.set(place.get() & !word);
        } else if address == flash.address(flash.cr()) {
            if !self.is_locked() {
                self.assert_free(now);
                self.write_control(word, now, alone);
            }
        } else if address == flash.address(flash.acr()) {
            self.write_access(word);
        } else {
            place.set(self.kept(address, place.get(), word));
        }
        true
    }

    fn key(&self, word: u32) {
        assert!(self.is_locked(), "keys are for a locked flash (3.6.1)");
        let next = match (self.keys.get(), word) {
            (Keys::None, 0x4567_0123) => Keys::First,
            (Keys::First, 0xcdef_89ab) => {
                let control = self.flash.get(self.flash.cr());
                self.flash.set(self.flash.cr(), control & !(1 << 31));
                assert!(!self.is_locked());
                Keys::None
            }
            _ => Keys::Wrong,
        };
        self.keys.set(next);
    }

    fn write_access(&self, word: u32) {
        let before = self.flash.acr().read();
        self.flash.set(self.flash.acr(), word);
        let after = self.flash.acr().read();
        if after.dcrst().bit() {
            assert!(!before.dcen().bit(), "the data cache is on (3.9.1)");
            self.stale[0].set(false);
        }
        // The vendor's description of the F4 leaves out bit 11, ICRST.
        let resets_instructions = word & 1 << 11 != 0;
        if resets_instructions {
            assert!(!before.icen().bit(), "the cache is on (3.9.1)");
            self.stale[1].set(false);
        }
        let on = after.dcen().bit() || after.icen().bit();
        let resets = after.dcrst().bit() || resets_instructions;
        assert!(!on || !resets, "a cache is on and reset at once (3.9.1)");
    }

    /// Begins a step; false if it fails.
    pub(crate) fn begin(&self, now: u64, takes: u64, alone: bool) -> bool {
        self.assert_free(now);
        assert!(alone, "an interrupt would stall");
        let flash = &self.flash;
        let errors = flash.get(flash.sr()) & ERRORS;
        assert_eq!(errors, 0, "no step begins with an error's flag");
        let end = if self.hangs.get() {
            u64::MAX
        } else {
            now + takes
        };
        self.busy_until.set(end);
        self.stale.iter().for_each(|cache| cache.set(true));
        let failed = self.fails.take();
        flash.set(flash.sr(), flash.get(flash.sr()) | failed);
        failed == 0
    }
}
