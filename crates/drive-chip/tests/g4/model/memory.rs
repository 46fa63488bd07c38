//! The flash and its interface (RM0440, FLASH).

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

use super::block::Block;
use super::clocks::Frequencies;
use crate::pac::{FLASH, flash};

/// Where the areas of the program's vectors and of the records begin and end.
const BASE: u32 = 0x0800_0000;
const END: u32 = 0x0801_0000;

/// Longest time by the data sheet, ns: 24.5 ms for a page, 91 µs for a double word.
const ERASURE: u64 = 24_500_000;
const DOUBLE_WORD: u64 = 91_000;

pub(crate) struct Memory {
    pub(crate) flash: Block<flash::RegisterBlock>,
    bytes: RefCell<Vec<u8>>,
    /// Double words that were written since they were erased.
    written: RefCell<BTreeSet<u32>>,
    /// Those of them whose bits do not fit their check: a loss of power has damaged them.
    damaged: RefCell<BTreeSet<u32>>,
    /// The first half of a double word, and its address.
    half: Cell<Option<(u32, u32)>>,
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
    /// Pages that were erased.
    pub(crate) erased: RefCell<Vec<u8>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Keys {
    None,
    First,
    /// A wrong one: nothing helps before a reset (FLASH).
    Wrong,
}

impl Memory {
    pub(crate) fn new() -> Self {
        let flash = Block::at(FLASH::ptr());
        // Reset values (FLASH), and options as delivered.
        flash.set(flash.acr(), 0x0004_0600);
        flash.set(flash.cr(), 0xc000_0000);
        flash.set(flash.optr(), 0xffef_f8aa);
        Self {
            flash,
            bytes: RefCell::new(vec![0xff; (END - BASE) as usize]),
            written: RefCell::default(),
            damaged: RefCell::default(),
            half: Cell::new(None),
            stale: Default::default(),
            keys: Cell::new(Keys::None),
            busy_until: Cell::new(0),
            fails: Cell::new(0),
            hangs: Cell::new(false),
            asked: Cell::new(0),
            erased: RefCell::default(),
        }
    }

    /// The content of the flash itself, past any cache.
    pub(crate) fn bytes(&self, address: u32, length: usize) -> Vec<u8> {
        let first = (address - BASE) as usize;
        self.bytes.borrow()[first..first + length].to_vec()
    }

    /// Puts whole double words there, as an earlier program did.
    pub(crate) fn put(&self, address: u32, bytes: &[u8]) {
        let first = (address - BASE) as usize;
        self.bytes.borrow_mut()[first..first + bytes.len()].copy_from_slice(bytes);
        let places = (address..).step_by(8).take(bytes.len() / 8);
        self.written.borrow_mut().extend(places);
    }

    /// Damages a double word, as a loss of power while it was written does.
    pub(crate) fn damage(&self, address: u32) {
        self.written.borrow_mut().insert(address);
        self.damaged.borrow_mut().insert(address);
    }

    /// Has a double word read as blank although it was written.
    pub(crate) fn write_blank(&self, address: u32) {
        self.written.borrow_mut().insert(address);
    }

    /// True if the flash asks for the interrupt that nothing masks.
    pub(crate) fn has_found_damage(&self) -> bool {
        let check = self.flash.eccr().read();
        check.eccd().bit() || check.eccd2().bit()
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

    /// True while it erases or writes.
    pub(crate) fn is_in_a_step(&self, now: u64) -> bool {
        now < self.busy_until.get()
    }

    /// Size of a page, bytes (FLASH).
    fn page(&self) -> u32 {
        if self.flash.optr().read().dbank().bit() {
            0x800
        } else {
            0x1000
        }
    }

    fn status(&self, now: u64) -> u32 {
        let flash = &self.flash;
        let busy = now < self.busy_until.get();
        let asked = self.asked.get() + 1;
        self.asked.set(asked);
        assert!(asked < 100_000_000, "the wait has no end");
        if !busy {
            // The start clears itself with the end (FLASH).
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
            assert!(now >= self.busy_until.get(), "the flash is busy (FLASH)");
            let is_cached = flash.acr().read().dcen().bit();
            assert!(
                !is_cached || !self.stale[0].get(),
                "read from a stale cache"
            );
            if self.damaged.borrow().contains(&(address & !0b111)) {
                flash.set(flash.eccr(), flash.get(flash.eccr()) | 1 << 31);
                assert!(flash.eccr().read().eccd().bit());
            }
            let first = (address - BASE) as usize;
            let bytes = self.bytes.borrow()[first..first + 4].try_into();
            return bytes.ok().map(u32::from_le_bytes);
        }
        flash.word(address).map(Cell::get)
    }

    pub(crate) fn write(&self, address: u32, word: u32, now: u64, alone: bool) -> bool {
        let flash = &self.flash;
        self.asked.set(0);
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
        } else if address == flash.address(flash.eccr()) {
            place.set(place.get() & !(word & 0xf000_0000));
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
        assert!(self.is_locked(), "keys are for a locked flash (FLASH)");
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
            assert!(!before.dcen().bit(), "the data cache is on (FLASH)");
            self.stale[0].set(false);
        }
        if after.icrst().bit() {
            assert!(!before.icen().bit(), "the cache is on (FLASH)");
            self.stale[1].set(false);
        }
        let on = after.dcen().bit() || after.icen().bit();
        let resets = after.dcrst().bit() || after.icrst().bit();
        assert!(!on || !resets, "a cache is on and reset at once (FLASH)");
    }

    /// Begins a step; false if it fails.
    fn begin(&self, now: u64, takes: u64, alone: bool) -> bool {
        assert!(now >= self.busy_until.get(), "the flash is busy (FLASH)");
        assert!(alone, "an interrupt would stall");
        let flash = &self.flash;
        let errors = flash.get(flash.sr()) & 0xc3fa;
        assert_eq!(errors, 0, "no step begins with an error's flag (FLASH)");
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

    fn write_control(&self, word: u32, now: u64, alone: bool) {
        let flash = &self.flash;
        if self.is_locked() {
            return;
        }
        assert!(now >= self.busy_until.get(), "the flash is busy (FLASH)");
        assert_eq!(self.half.get(), None, "half a double word was written");
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
            self.written.borrow_mut().retain(stays);
            self.damaged.borrow_mut().retain(stays);
        }
    }

    /// Halves of a double word, in their order (FLASH).
    fn program(&self, address: u32, word: u32, now: u64, alone: bool) {
        let flash = &self.flash;
        let control = flash.cr().read();
        assert!(
            !control.lock().bit() && control.pg().bit() && !control.fstpg().bit(),
            "out of order (FLASH)"
        );
        assert!(alone, "an interrupt between the halves");
        let Some((place, low)) = self.half.take() else {
            assert_eq!(address % 8, 0, "the first half is the lower one");
            self.half.set(Some((address, word)));
            return;
        };
        assert_eq!(address, place + 4, "the halves belong together");
        if !self.begin(now, DOUBLE_WORD, alone) {
            return;
        }
        let is_erased = !self.written.borrow().contains(&place);
        if !is_erased && (low, word) != (0, 0) {
            flash.set(flash.sr(), flash.get(flash.sr()) | 1 << 3);
            assert!(flash.sr().read().progerr().bit());
            return;
        }
        let first = (place - BASE) as usize;
        let mut bytes = self.bytes.borrow_mut();
        bytes[first..first + 4].copy_from_slice(&low.to_le_bytes());
        bytes[first + 4..first + 8].copy_from_slice(&word.to_le_bytes());
        self.written.borrow_mut().insert(place);
        self.damaged.borrow_mut().remove(&place);
    }
}
