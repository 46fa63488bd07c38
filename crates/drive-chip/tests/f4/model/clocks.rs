//! Reset and clock control (RM0090, 7).

use std::cell::Cell;

use stm32f4::stm32f405::{RCC, rcc};

use super::Chip;
use super::block::Block;

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
    /// Reads since the prescalers were changed.
    since_prescalers: Cell<u32>,
    /// A peripheral was switched on, and nothing was read since.
    just_on: Cell<bool>,
}

/// Reads of a register until a ready bit rises.
const WAIT: u32 = 4;

/// Ticks, and so reads, until a new prescaler holds.
const PRESCALER_TICKS: u32 = 16;

/// The internal oscillator, Hz.
const HSI: f64 = 16e6;

impl Clocks {
    pub(crate) fn new(source: Source) -> Self {
        let rcc = Block::at(RCC::ptr());
        rcc.set(rcc.cr(), 0x83);
        rcc.set(rcc.pllcfgr(), 0x2400_3010);
        rcc.set(rcc.csr(), 0x0e00_0000);
        Self {
            rcc,
            source,
            pll_fails: Cell::new(false),
            switch_fails: Cell::new(false),
            wait: Cell::new(WAIT),
            since_prescalers: Cell::new(u32::MAX),
            just_on: Cell::new(false),
        }
    }

    /// True if the watchdog reset the chip.
    pub(crate) fn blames_watchdog(&self) -> bool {
        self.rcc.csr().read().wdgrstf().is_reset()
    }

    fn external(&self) -> Option<f64> {
        match self.source {
            Source::Crystal(frequency) if self.rcc.cr().read().hsebyp().is_not_bypassed() => {
                Some(frequency)
            }
            Source::Clock(frequency) if self.rcc.cr().read().hsebyp().is_bypassed() => {
                Some(frequency)
            }
            _ => None,
        }
    }

    /// The PLL's output, Hz (7.3.2).
    fn pll(&self) -> f64 {
        let factors = self.rcc.pllcfgr().read();
        let input = if factors.pllsrc().is_hse() {
            self.external().unwrap_or(0.0)
        } else {
            HSI
        };
        let compared = input / f64::from(factors.pllm().bits());
        assert!(
            (1e6..=2e6).contains(&compared),
            "the PLL compares at {compared} Hz (7.3.2)"
        );
        let vco = compared * f64::from(factors.plln().bits());
        assert!(
            (100e6..=432e6).contains(&vco),
            "the VCO oscillates at {vco} Hz (7.3.2)"
        );
        let usb = vco / f64::from(factors.pllq().bits());
        assert!((usb - 48e6).abs() < 1.0, "the 48 MHz are {usb} Hz (7.3.2)");
        vco / f64::from(2 * (factors.pllp().bits() + 1))
    }

    /// The clock frequencies in force.
    pub(crate) fn frequencies(&self) -> Frequencies {
        let cfgr = self.rcc.cfgr().read();
        let source = if cfgr.sws().is_pll() {
            self.pll()
        } else if cfgr.sws().is_hse() {
            self.external().unwrap_or(0.0)
        } else {
            HSI
        };
        let divided = |bits: u8, none: u8| {
            if bits < none {
                1.0
            } else {
                f64::from(2_u32 << (bits - none))
            }
        };
        // There is no factor of 32 (7.3.3).
        let skipped = if cfgr.hpre().bits() < 0b1100 {
            1.0
        } else {
            2.0
        };
        let processor = source / divided(cfgr.hpre().bits(), 0b1000) / skipped;
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

    fn check(&self) {
        let Frequencies {
            processor,
            low_bus,
            high_bus,
            ..
        } = self.frequencies();
        assert!(processor <= 168e6, "the processor runs at {processor} Hz");
        assert!(low_bus <= 42e6, "APB1 runs at {low_bus} Hz (7.2)");
        assert!(high_bus <= 84e6, "APB2 runs at {high_bus} Hz (7.2)");
    }

    /// True if the clock security system watches the source of the processor's clock.
    pub(crate) fn is_watched(&self) -> bool {
        self.rcc.cr().read().csson().is_on()
    }

    /// True if all registers have their values after reset, but for flags.
    pub(crate) fn are_reset(&self) -> bool {
        let rcc = &self.rcc;
        rcc.get(rcc.cr()) == 0x83 && rcc.get(rcc.cfgr()) == 0
    }

    /// True if a peripheral's clock is on.
    pub(crate) fn is_on(&self, peripheral: Peripheral) -> bool {
        let (ahb1, apb1, apb2) = (
            self.rcc.ahb1enr().read(),
            self.rcc.apb1enr().read(),
            self.rcc.apb2enr().read(),
        );
        match peripheral {
            Peripheral::Port(0) => ahb1.gpioaen().is_enabled(),
            Peripheral::Port(1) => ahb1.gpioben().is_enabled(),
            Peripheral::Port(2) => ahb1.gpiocen().is_enabled(),
            Peripheral::Port(_) => false,
            Peripheral::Tim1 => apb2.tim1en().is_enabled(),
            Peripheral::Tim4 => apb1.tim4en().is_enabled(),
            Peripheral::Tim3 => apb1.tim3en().is_enabled(),
            Peripheral::Tim5 => apb1.tim5en().is_enabled(),
            Peripheral::Usart2 => apb1.usart2en().is_enabled(),
            Peripheral::Dma1 => ahb1.dma1en().is_enabled(),
        }
    }

    /// True if a write reaches a peripheral: its clock is on, and has been for two ticks.
    pub(crate) fn reaches(&self, peripheral: Peripheral) -> bool {
        assert!(
            !self.just_on.get(),
            "{peripheral:?} was switched on within two ticks (7.2.13)"
        );
        self.is_on(peripheral)
    }

    /// Resets the peripherals whose bit is set.
    pub(crate) fn reset_peripherals(&self, chip: &Chip) {
        let (apb1, apb2) = (self.rcc.apb1rstr().read(), self.rcc.apb2rstr().read());
        if apb2.tim1rst().bit() {
            chip.timers.reset(Peripheral::Tim1);
        }
        if apb1.tim3rst().bit() {
            chip.timers.reset(Peripheral::Tim3);
        }
        if apb1.tim4rst().bit() {
            chip.timers.reset(Peripheral::Tim4);
        }
        if apb1.tim5rst().bit() {
            chip.timers.reset(Peripheral::Tim5);
        }
        if apb1.usart2rst().bit() {
            chip.usart.reset();
        }
        if self.rcc.ahb1rstr().read().dma1rst().bit() {
            chip.usart.reset_dma();
        }
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
        let reads = self.since_prescalers.get().saturating_add(1);
        self.since_prescalers.set(reads);
        if address == rcc.address(rcc.cr()) {
            let state = rcc.cr().read();
            let (on, ready) = (state.hseon().is_on(), state.hserdy().is_ready());
            if on && !ready && self.external().is_some() && self.waited() {
                self.raise(1 << 17);
                assert!(rcc.cr().read().hserdy().is_ready());
            }
            let (on, ready) = (state.pllon().is_on(), state.pllrdy().is_ready());
            if on && !ready && !self.pll_fails.get() && self.waited() {
                self.raise(1 << 25);
                assert!(rcc.cr().read().pllrdy().is_ready());
            }
        } else if address == rcc.address(rcc.cfgr()) {
            let (switch, state) = (rcc.cfgr().read(), rcc.cr().read());
            let wanted = u32::from(switch.sw().bits());
            let ready = match wanted {
                0 => true,
                1 => state.hserdy().is_ready(),
                _ => state.pllrdy().is_ready() && !self.switch_fails.get(),
            };
            if ready && wanted != u32::from(switch.sws().bits()) && self.waited() {
                word.set(word.get() & !(0b11 << 2) | wanted << 2);
                assert_eq!(u32::from(rcc.cfgr().read().sws().bits()), wanted);
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
            assert!(rcc.cr().read().pllon().is_off(), "the PLL is on (7.3.2)");
            let reserved = 0xf0bc_8000;
            assert_eq!(old & reserved, new & reserved, "reserved bits (7.3.2)");
            word.set(new);
        } else if address == rcc.address(rcc.cfgr()) {
            // The field of the source in use is read-only.
            word.set(new & !(0b11 << 2) | old & (0b11 << 2));
            let prescalers = 0xf << 4 | 0x3f << 10;
            if (old ^ new) & prescalers != 0 {
                self.since_prescalers.set(0);
            }
            assert!(
                (old ^ new) & 0b11 == 0 || self.since_prescalers.get() >= PRESCALER_TICKS,
                "the prescalers hold up to 16 ticks after they are written (7.3.3): later than the \
                 switch"
            );
            self.wait.set(WAIT);
            self.check();
        } else if address == rcc.address(rcc.csr()) {
            word.set(if new & 1 << 24 != 0 { 0 } else { old });
        } else {
            let enables = [
                rcc.address(rcc.ahb1enr()),
                rcc.address(rcc.apb1enr()),
                rcc.address(rcc.apb2enr()),
            ];
            if enables.contains(&address) && new & !old != 0 {
                self.just_on.set(true);
            }
            word.set(new);
        }
        true
    }

    fn write_control(&self, old: u32, new: u32) {
        let rcc = &self.rcc;
        let before = rcc.cr().read();
        let ready = 1 << 1 | 1 << 17 | 1 << 25;
        let mut word = new & !ready | old & ready;
        if before.hseon().is_on() {
            // It is not written while the oscillator is on (7.3.1).
            word = word & !(1 << 18) | old & 1 << 18;
        }
        rcc.set(rcc.cr(), word);
        let after = rcc.cr().read();
        let used = rcc.cfgr().read().sws();
        if after.hseon().is_off() {
            assert!(used.is_hsi(), "the clock in use is switched off (7.3.1)");
            assert!(after.pllon().is_off(), "the PLL's source is switched off");
            rcc.set(rcc.cr(), rcc.get(rcc.cr()) & !(1 << 17));
        }
        if after.pllon().is_off() {
            assert!(!used.is_pll(), "the clock in use is switched off (7.3.1)");
            rcc.set(rcc.cr(), rcc.get(rcc.cr()) & !(1 << 25));
        } else if before.pllon().is_off() {
            assert!(
                rcc.pllcfgr().read().pllsrc().is_hsi() || after.hserdy().is_ready(),
                "the PLL's source is not ready (7.3.2)"
            );
            self.pll();
        }
        self.wait.set(WAIT);
    }
}

/// A peripheral whose clock is switched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Peripheral {
    Port(usize),
    Tim1,
    Tim3,
    Tim4,
    Tim5,
    Usart2,
    Dma1,
}
