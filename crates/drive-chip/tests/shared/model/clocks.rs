//! Reset and clock control: what both families have (RM0090, 7; RM0440, RCC).

use std::cell::Cell;

use super::block::Block;
use crate::model::clocks::{CFGR, CR, FIRST_SOURCE, KEPT, READY, RESERVED, RMVF};
pub(crate) use crate::model::clocks::{Own, Peripheral};
use crate::pac::{RCC, rcc};

/// The clock source at the oscillator pins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Source {
    /// A crystal, Hz.
    Crystal(f64),
    /// A clock, Hz.
    Clock(f64),
    /// Nothing that works.
    Nothing,
}

/// Clock frequencies, Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frequencies {
    pub(crate) processor: f64,
    pub(crate) low_bus: f64,
    pub(crate) high_bus: f64,
    pub(crate) low_timers: f64,
    pub(crate) high_timers: f64,
}

pub(crate) struct Clocks {
    pub(crate) rcc: Block<rcc::RegisterBlock>,
    source: Source,
    /// The PLL never locks.
    pub(crate) pll_fails: Cell<bool>,
    /// The switch to the PLL never happens.
    pub(crate) switch_fails: Cell<bool>,
    /// Reads until the step that was begun is ready.
    wait: Cell<u32>,
    /// A peripheral was switched on, and nothing was read since.
    just_on: Cell<bool>,
    pub(crate) own: Own,
}

/// Reads of a register until a ready bit rises.
const WAIT: u32 = 4;

/// The internal oscillator, Hz.
pub(crate) const HSI: f64 = 16e6;

impl Clocks {
    pub(crate) fn new(source: Source) -> Self {
        let rcc = Block::at(RCC::ptr());
        rcc.set(rcc.cr(), CR);
        rcc.set(rcc.cfgr(), CFGR);
        Self::set_others_after_reset(&rcc);
        Self {
            rcc,
            source,
            pll_fails: Cell::new(false),
            switch_fails: Cell::new(false),
            wait: Cell::new(WAIT),
            just_on: Cell::new(false),
            own: Own::default(),
        }
    }

    /// The frequency of the external source, Hz.
    pub(crate) fn external(&self) -> Option<f64> {
        let is_bypassed = self.rcc.cr().read().hsebyp().bit();
        match self.source {
            Source::Crystal(frequency) if !is_bypassed => Some(frequency),
            Source::Clock(frequency) if is_bypassed => Some(frequency),
            _ => None,
        }
    }

    /// The source of the processor's clock, Hz.
    pub(crate) fn source(&self) -> f64 {
        let used = self.rcc.cfgr().read().sws();
        if used.is_pll() {
            self.pll()
        } else if used.is_hse() {
            self.external().unwrap_or(0.0)
        } else {
            HSI
        }
    }

    /// The clock frequencies in force.
    pub(crate) fn frequencies(&self) -> Frequencies {
        let cfgr = self.rcc.cfgr().read();
        let divided = |bits: u8, none: u8| {
            if bits < none {
                1.0
            } else {
                f64::from(2_u32 << (bits - none))
            }
        };
        // There is no factor of 32 (RM0090, 7.3.3).
        let skipped = if cfgr.hpre().bits() < 0b1100 {
            1.0
        } else {
            2.0
        };
        let processor = self.source() / divided(cfgr.hpre().bits(), 0b1000) / skipped;
        let (low, high) = (
            divided(cfgr.ppre1().bits(), 0b100),
            divided(cfgr.ppre2().bits(), 0b100),
        );
        let timers = |bus: f64, factor: f64| if factor > 1.0 { 2.0 * bus } else { bus };
        let (low_bus, high_bus) = (processor / low, processor / high);
        Frequencies {
            processor,
            low_bus,
            high_bus,
            low_timers: timers(low_bus, low),
            high_timers: timers(high_bus, high),
        }
    }

    /// True if the clock security system watches the source of the processor's clock.
    pub(crate) fn is_watched(&self) -> bool {
        self.rcc.cr().read().csson().bit()
    }

    /// True if all registers have their values after reset, but for flags.
    pub(crate) fn are_reset(&self) -> bool {
        let rcc = &self.rcc;
        rcc.get(rcc.cr()) == CR && rcc.get(rcc.cfgr()) == CFGR
    }

    /// True if a write reaches a peripheral: its clock is on, and has been for two ticks.
    pub(crate) fn reaches(&self, peripheral: Peripheral) -> bool {
        assert!(
            !self.just_on.get(),
            "{peripheral:?} was switched on within two ticks (RM0090, 7.2.13)"
        );
        self.is_on(peripheral)
    }

    /// True if the step that was begun is complete.
    fn waited(&self) -> bool {
        let left = self.wait.get().saturating_sub(1);
        self.wait.set(left);
        left == 0
    }

    fn raise(&self, bit: u32) {
        let rcc = &self.rcc;
        rcc.set(rcc.cr(), rcc.get(rcc.cr()) | bit);
    }

    pub(crate) fn read(&self, address: u32) -> Option<u32> {
        let rcc = &self.rcc;
        let word = rcc.word(address)?;
        self.just_on.set(false);
        self.own.tick();
        if address == rcc.address(rcc.cr()) {
            let state = rcc.cr().read();
            let (on, ready) = (state.hseon().bit(), state.hserdy().bit());
            if on && !ready && self.external().is_some() && self.waited() {
                self.raise(1 << 17);
                assert!(rcc.cr().read().hserdy().bit());
            }
            let (on, ready) = (state.pllon().bit(), state.pllrdy().bit());
            if on && !ready && !self.pll_fails.get() && self.waited() {
                self.raise(1 << 25);
                assert!(rcc.cr().read().pllrdy().bit());
            }
        } else if address == rcc.address(rcc.cfgr()) {
            let (switch, state) = (rcc.cfgr().read(), rcc.cr().read());
            let wanted = u32::from(switch.sw().bits());
            let ready = match wanted.checked_sub(FIRST_SOURCE) {
                Some(0) => true,
                Some(1) => state.hserdy().bit(),
                Some(2) => state.pllrdy().bit() && !self.switch_fails.get(),
                _ => panic!("there is no such source"),
            };
            if ready && wanted != u32::from(switch.sws().bits()) && self.waited() {
                word.set(word.get() & !(0b11 << 2) | wanted << 2);
                assert_eq!(u32::from(rcc.cfgr().read().sws().bits()), wanted);
                self.own.switched();
                self.check();
            }
        }
        Some(word.get())
    }

    pub(crate) fn write(&self, address: u32, new: u32) -> bool {
        let rcc = &self.rcc;
        let Some(word) = rcc.word(address) else {
            return false;
        };
        let old = word.get();
        if address == rcc.address(rcc.cr()) {
            self.write_control(old, new);
        } else if address == rcc.address(rcc.pllcfgr()) {
            assert!(!rcc.cr().read().pllon().bit(), "the PLL is on");
            assert_eq!(old & RESERVED, new & RESERVED, "reserved bits");
            word.set(new);
        } else if address == rcc.address(rcc.cfgr()) {
            // The field of the source in use is read-only.
            word.set(new & !(0b11 << 2) | old & (0b11 << 2));
            self.own.configured(old ^ new);
            self.wait.set(WAIT);
            self.check();
        } else if address == rcc.address(rcc.csr()) {
            word.set(if new & RMVF != 0 { 0 } else { old });
        } else {
            if self.enables().contains(&address) && new & !old != 0 {
                self.just_on.set(true);
            }
            word.set(new);
        }
        true
    }

    fn write_control(&self, old: u32, new: u32) {
        let rcc = &self.rcc;
        let before = rcc.cr().read();
        let mut word = new & !READY | old & (READY | KEPT);
        if before.hseon().bit() {
            // It is not written while the oscillator is on.
            word = word & !(1 << 18) | old & 1 << 18;
        }
        rcc.set(rcc.cr(), word);
        let after = rcc.cr().read();
        let used = rcc.cfgr().read().sws();
        assert!(after.hsion().bit(), "the internal oscillator is off");
        if !after.hseon().bit() {
            assert!(used.is_hsi(), "the clock in use is switched off");
            assert!(!after.pllon().bit(), "the PLL's source is switched off");
            assert!(
                !after.csson().bit(),
                "a watched oscillator is taken for failed"
            );
            rcc.set(rcc.cr(), rcc.get(rcc.cr()) & !(1 << 17));
        }
        if !after.pllon().bit() {
            assert!(!used.is_pll(), "the clock in use is switched off");
            rcc.set(rcc.cr(), rcc.get(rcc.cr()) & !(1 << 25));
        } else if !before.pllon().bit() {
            assert!(after.hserdy().bit(), "the PLL's source is not ready");
            self.pll();
        }
        self.wait.set(WAIT);
    }
}
