//! Reset and clock control (RM0440, RCC), and the boost of the core's voltage (PWR).

use std::cell::Cell;

use super::Chip;
use super::block::Block;
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
    /// The core's voltage is boosted.
    pub(crate) is_boosted: Cell<bool>,
    /// Reads until the step that was begun is ready.
    wait: Cell<u32>,
    /// Reads since the clock was switched.
    since_switch: Cell<u32>,
    /// A peripheral was switched on, and nothing was read since.
    just_on: Cell<bool>,
}

/// Reads of a register until a ready bit rises.
const WAIT: u32 = 4;

/// Ticks of 85 MHz, and so reads, in the microsecond that begins with half of the clock (PWR).
const HALVED_TICKS: u32 = 85;

/// The internal oscillator, Hz.
const HSI: f64 = 16e6;

/// The highest frequency without the boost, Hz (PWR).
const NORMAL: f64 = 150e6;

/// Values after reset (RCC).
const CR: u32 = 0x500;
const CFGR: u32 = 0x5;

impl Clocks {
    pub(crate) fn new(source: Source) -> Self {
        let rcc = Block::at(RCC::ptr());
        rcc.set(rcc.cr(), CR);
        rcc.set(rcc.cfgr(), CFGR);
        rcc.set(rcc.pllcfgr(), 0x1000);
        rcc.set(rcc.csr(), 0x0c00_0000);
        rcc.set(rcc.ahb1enr(), 0x100);
        rcc.set(rcc.apb1enr1(), 0x400);
        Self {
            rcc,
            source,
            pll_fails: Cell::new(false),
            switch_fails: Cell::new(false),
            is_boosted: Cell::new(false),
            wait: Cell::new(WAIT),
            since_switch: Cell::new(u32::MAX),
            just_on: Cell::new(false),
        }
    }

    /// True if the watchdog reset the chip.
    pub(crate) fn blames_watchdog(&self) -> bool {
        self.rcc.csr().read().iwdgrstf().bit()
    }

    fn external(&self) -> Option<f64> {
        let is_bypassed = self.rcc.cr().read().hsebyp().bit();
        match self.source {
            Source::Crystal(frequency) if !is_bypassed => Some(frequency),
            Source::Clock(frequency) if is_bypassed => Some(frequency),
            _ => None,
        }
    }

    /// The PLL's output R, Hz (RCC).
    fn pll(&self) -> f64 {
        let factors = self.rcc.pllcfgr().read();
        let input = match factors.pllsrc().bits() {
            0b11 => self.external().unwrap_or(0.0),
            0b10 => HSI,
            _ => panic!("the PLL has no source"),
        };
        let compared = input / (f64::from(factors.pllm().bits()) + 1.0);
        assert!(
            (2.66e6..=16e6).contains(&compared),
            "the PLL compares at {compared} Hz"
        );
        let vco = compared * f64::from(factors.plln().bits());
        assert!(
            (96e6..=344e6).contains(&vco),
            "the VCO oscillates at {vco} Hz"
        );
        assert!(factors.pllren().bit(), "its output is off");
        assert!(!factors.pllpen().bit() && !factors.pllqen().bit());
        vco / (2.0 * (f64::from(factors.pllr().bits()) + 1.0))
    }

    /// The source of the processor's clock, Hz.
    fn source(&self) -> f64 {
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
        let processor = self.source() / divided(cfgr.hpre().bits(), 0b1000);
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
        let processor = self.frequencies().processor;
        assert!(processor <= 170e6, "the processor runs at {processor} Hz");
        if self.source() > NORMAL {
            assert!(self.is_boosted.get(), "{processor} Hz without the boost");
            let is_half = processor <= self.source() / 2.0;
            assert!(
                is_half || self.since_switch.get() >= HALVED_TICKS,
                "the first microsecond takes half of the clock (PWR)"
            );
        }
    }

    /// Sets whether the core's voltage is boosted.
    pub(crate) fn boost(&self, boosted: bool) {
        self.is_boosted.set(boosted);
        self.check();
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

    /// True if a peripheral's clock is on.
    pub(crate) fn is_on(&self, peripheral: Peripheral) -> bool {
        let rcc = &self.rcc;
        let (ahb1, ahb2) = (rcc.ahb1enr().read(), rcc.ahb2enr().read());
        let (apb1, apb2) = (rcc.apb1enr1().read(), rcc.apb2enr().read());
        match peripheral {
            Peripheral::Port(0) => ahb2.gpioaen().bit(),
            Peripheral::Port(1) => ahb2.gpioben().bit(),
            Peripheral::Port(2) => ahb2.gpiocen().bit(),
            Peripheral::Port(_) => false,
            Peripheral::Tim1 => apb2.tim1en().bit(),
            Peripheral::Tim3 => apb1.tim3en().bit(),
            Peripheral::Tim4 => apb1.tim4en().bit(),
            Peripheral::Tim5 => apb1.tim5en().bit(),
            Peripheral::Usart2 => apb1.usart2en().bit(),
            Peripheral::Dma1 => ahb1.dma1en().bit() && ahb1.dmamux1en().bit(),
            Peripheral::Dac3 => ahb2.dac3en().bit(),
            Peripheral::Syscfg => apb2.syscfgen().bit(),
            Peripheral::Pwr => apb1.pwren().bit(),
        }
    }

    /// True if a write reaches a peripheral: its clock is on, and has been for two ticks.
    pub(crate) fn reaches(&self, peripheral: Peripheral) -> bool {
        assert!(
            !self.just_on.get(),
            "{peripheral:?} was switched on within two ticks (RCC)"
        );
        self.is_on(peripheral)
    }

    /// Resets the peripherals whose bit is set.
    pub(crate) fn reset_peripherals(&self, chip: &Chip) {
        let rcc = &self.rcc;
        let (ahb1, ahb2) = (rcc.ahb1rstr().read(), rcc.ahb2rstr().read());
        let (apb1, apb2) = (rcc.apb1rstr1().read(), rcc.apb2rstr().read());
        for (is_reset, peripheral) in [
            (apb2.tim1rst().bit(), Peripheral::Tim1),
            (apb1.tim3rst().bit(), Peripheral::Tim3),
            (apb1.tim4rst().bit(), Peripheral::Tim4),
            (apb1.tim5rst().bit(), Peripheral::Tim5),
        ] {
            if is_reset {
                chip.timers.reset(peripheral);
            }
        }
        if apb1.usart2rst().bit() {
            chip.usart.reset();
        }
        if ahb1.dma1rst().bit() && ahb1.dmamux1rst().bit() {
            chip.usart.reset_dma();
        }
        if ahb2.dac3rst().bit() && apb2.syscfgrst().bit() {
            chip.supply.reset();
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
        let reads = self.since_switch.get().saturating_add(1);
        self.since_switch.set(reads);
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
            let ready = match wanted {
                1 => true,
                2 => state.hserdy().bit(),
                3 => state.pllrdy().bit() && !self.switch_fails.get(),
                _ => panic!("there is no such source (RCC)"),
            };
            if ready && wanted != u32::from(switch.sws().bits()) && self.waited() {
                word.set(word.get() & !(0b11 << 2) | wanted << 2);
                assert_eq!(u32::from(rcc.cfgr().read().sws().bits()), wanted);
                self.since_switch.set(0);
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
            assert!(!rcc.cr().read().pllon().bit(), "the PLL is on (RCC)");
            word.set(new);
        } else if address == rcc.address(rcc.cfgr()) {
            // The field of the source in use is read-only.
            word.set(new & !(0b11 << 2) | old & (0b11 << 2));
            self.wait.set(WAIT);
            self.check();
        } else if address == rcc.address(rcc.csr()) {
            word.set(if new & 1 << 23 != 0 { 0 } else { old });
        } else {
            let enables = [
                rcc.address(rcc.ahb1enr()),
                rcc.address(rcc.ahb2enr()),
                rcc.address(rcc.apb1enr1()),
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
        let ready = 1 << 10 | 1 << 17 | 1 << 25;
        // Only a reset ends the watch (RCC).
        let mut word = new & !ready | old & (ready | 1 << 19);
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

/// A peripheral whose clock is switched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Peripheral {
    Port(usize),
    Tim1,
    Tim3,
    Tim4,
    Tim5,
    Usart2,
    /// With its multiplexer.
    Dma1,
    Dac3,
    /// With the comparators.
    Syscfg,
    Pwr,
}
