//! The independent watchdog (RM0090, 21).

use std::cell::Cell;

use super::block::Block;
use crate::pac::{IWDG, iwdg};

/// Its oscillator at its fastest, Hz, by the data sheet.
const FASTEST: f64 = 47e3;

/// Time until a new prescaler or reload is in force, ns: five ticks of the oscillator (21.4).
const UPDATE: u64 = 156_000;

pub(crate) struct Watchdog {
    iwdg: Block<iwdg::RegisterBlock>,
    open: Cell<bool>,
    updating_until: Cell<u64>,
    /// Ticks of the oscillator from food to reset that hold now.
    patience: Cell<u32>,
    hungry_at: Cell<Option<u64>>,
    /// It has reset the chip.
    pub(crate) bit: Cell<bool>,
    /// Times that it was fed.
    pub(crate) meals: Cell<u64>,
}

impl Watchdog {
    pub(crate) fn new() -> Self {
        let iwdg = Block::at(IWDG::ptr());
        iwdg.set(iwdg.rlr(), 0xfff);
        Self {
            iwdg,
            open: Cell::new(false),
            updating_until: Cell::new(0),
            patience: Cell::new(4 * 0x1000),
            hungry_at: Cell::new(None),
            bit: Cell::new(false),
            meals: Cell::new(0),
        }
    }

    /// True if it counts down.
    pub(crate) fn is_awake(&self) -> bool {
        self.hungry_at.get().is_some()
    }

    /// Its patience in ticks of its oscillator.
    pub(crate) fn patience(&self) -> u32 {
        self.patience.get()
    }

    pub(crate) fn look(&self, now: u64) {
        if self.hungry_at.get().is_some_and(|hungry| now > hungry) {
            self.bit.set(true);
        }
    }

    fn begin(&self, now: u64) {
        let nanoseconds = f64::from(self.patience.get()) / FASTEST * 1e9;
        self.hungry_at.set(Some(now + nanoseconds as u64));
    }

    /// Takes food; false if it is none.
    pub(crate) fn feed(&self, address: u32, word: u32, now: u64) -> bool {
        let food = address == self.iwdg.address(self.iwdg.kr()) && word == 0xaaaa;
        if food {
            self.open.set(false);
            self.meals.set(self.meals.get() + 1);
            self.settle(now);
            if self.hungry_at.get().is_some() {
                self.begin(now);
            }
        }
        food
    }

    /// Puts a written value in force after its update time.
    fn settle(&self, now: u64) {
        if now >= self.updating_until.get() {
            let divider = 4 << self.iwdg.pr().read().pr().bits().min(6);
            let reload = u32::from(self.iwdg.rlr().read().rl().bits());
            self.patience.set(divider * (reload + 1));
        }
    }

    pub(crate) fn read(&self, address: u32, now: u64) -> Option<u32> {
        let iwdg = &self.iwdg;
        let word = iwdg.word(address)?;
        if address == iwdg.address(iwdg.sr()) {
            return Some(if now < self.updating_until.get() {
                0b11
            } else {
                0
            });
        }
        Some(word.get())
    }

    pub(crate) fn write(&self, address: u32, word: u32, now: u64) -> bool {
        let iwdg = &self.iwdg;
        let Some(place) = iwdg.word(address) else {
            return false;
        };
        if address == iwdg.address(iwdg.kr()) {
            self.open.set(word == 0x5555);
            if word == 0xcccc {
                self.begin(now);
            }
        } else if self.open.get() {
            place.set(word);
            self.updating_until.set(now + UPDATE);
        }
        true
    }
}
