//! The flash and its interface (RM0090, 3).

use std::cell::{Cell, RefCell};

use stm32f4::stm32f405::{FLASH, flash};

use super::block::Block;
use super::clocks::Frequencies;

/// Where the four sectors of 16 KiB begin and end (table 5).
const BASE: u32 = 0x0800_0000;
const END: u32 = 0x0801_0000;
const SECTOR: u32 = 0x4000;

/// Longest time by the data sheet, ns: 0.5 s for such a sector, 100 µs for a word.
const ERASURE: u64 = 500_000_000;
const WORD: u64 = 100_000;

pub(crate) struct Memory {
    pub(crate) flash: Block<flash::RegisterBlock>,
    bytes: RefCell<Vec<u8>>,
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
    /// Sectors that were erased.
    pub(crate) erased: RefCell<Vec<u8>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Keys {
    None,
    First,
    /// A wrong one: nothing helps before a reset (3.6.1).
    Wrong,
}

impl Memory {
    pub(crate) fn new() -> Self {
        let flash = Block::at(FLASH::ptr());
        flash.set(flash.cr(), 0x8000_0000);
        Self {
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
        }
    }

    /// The content of the flash itself, past any cache.
    pub(crate) fn bytes(&self, address: u32, length: usize) -> Vec<u8> {
        let first = (address - BASE) as usize;
        self.bytes.borrow()[first..first + length].to_vec()
    }

    /// Puts bytes there, as an earlier program did.
    pub(crate) fn put(&self, address: u32, bytes: &[u8]) {
        let first = (address - BASE) as usize;
        self.bytes.borrow_mut()[first..first + bytes.len()].copy_from_slice(bytes);
    }

    pub(crate) fn is_locked(&self) -> bool {
        self.flash.cr().read().lock().is_locked()
    }

    /// True if both caches and the prefetch are on.
    pub(crate) fn is_cached(&self) -> bool {
        let access = self.flash.acr().read();
        access.dcen().is_enabled() && access.icen().is_enabled() && access.prften().is_enabled()
    }

    pub(crate) fn is_stale(&self) -> bool {
        self.stale.iter().any(Cell::get)
    }

    /// The wait states in force.
    pub(crate) fn wait_states(&self) -> u8 {
        self.flash.acr().read().latency().bits()
    }

    /// At 2.7 V and more, a wait state for each 30 MHz begun (table 10).
    pub(crate) fn check_wait_states(&self, frequencies: Frequencies) {
        let states = f64::from(self.flash.acr().read().latency().bits());
        assert!(
            frequencies.processor <= 30e6 * (states + 1.0),
            "{states} wait states at {} Hz",
            frequencies.processor
        );
    }

    /// True while it erases or writes.
    pub(crate) fn is_in_a_step(&self, now: u64) -> bool {
        now < self.busy_until.get()
    }

    /// It recognises none.
    pub(crate) fn has_found_damage(&self) -> bool {
        false
    }

    fn status(&self, now: u64) -> u32 {
        let flash = &self.flash;
        let busy = now < self.busy_until.get();
        let asked = self.asked.get() + 1;
        self.asked.set(asked);
        assert!(asked < 100_000_000, "the wait has no end");
        if !busy {
            self.asked.set(0);
            let idle = self.idle.get() + 1;
            self.idle.set(idle);
            assert!(idle < 10, "the end of the wait is not seen");
            // The start clears itself with the end (3.9.6).
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
            assert!(now >= self.busy_until.get(), "the flash is busy (3.6)");
            let is_cached = self.flash.acr().read().dcen().is_enabled();
            assert!(
                !is_cached || !self.stale[0].get(),
                "read from a stale cache"
            );
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
            self.write_control(word, now, alone);
        } else if address == flash.address(flash.acr()) {
            self.write_access(word);
        } else {
            place.set(word);
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
        if after.dcrst().is_reset() {
            assert!(before.dcen().is_disabled(), "the data cache is on (3.9.1)");
            self.stale[0].set(false);
        }
        // The vendor's description leaves out bit 11, ICRST.
        if word & 1 << 11 != 0 {
            assert!(before.icen().is_disabled(), "the cache is on (3.9.1)");
            self.stale[1].set(false);
        }
        let on = after.dcen().is_enabled() || after.icen().is_enabled();
        let resets = after.dcrst().is_reset() || word & 1 << 11 != 0;
        assert!(!on || !resets, "a cache is on and reset at once (3.9.1)");
    }

    fn begin(&self, now: u64, takes: u64, alone: bool) {
        assert!(now >= self.busy_until.get(), "the flash is busy (3.6)");
        assert!(alone, "an interrupt would stall");
        let end = if self.hangs.get() {
            u64::MAX
        } else {
            now + takes
        };
        self.busy_until.set(end);
        self.stale.iter().for_each(|cache| cache.set(true));
        let flash = &self.flash;
        let failed = self.fails.take();
        flash.set(flash.sr(), flash.get(flash.sr()) | failed);
    }

    fn write_control(&self, word: u32, now: u64, alone: bool) {
        let flash = &self.flash;
        if self.is_locked() {
            return;
        }
        assert!(now >= self.busy_until.get(), "the flash is busy (3.6)");
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

    fn program(&self, address: u32, word: u32, now: u64, alone: bool) {
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
