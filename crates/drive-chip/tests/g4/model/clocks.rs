//! Reset and clock control of the STM32G4 (RM0440, RCC), and the boost of the core's voltage (PWR).

use std::cell::Cell;

use super::Chip;
use super::block::Block;
use crate::pac::rcc;
use crate::shared::model::clocks::{Clocks, HSI};

/// Values after reset.
pub(crate) const CR: u32 = 0x500;
pub(crate) const CFGR: u32 = 0x5;

/// Flags of what is ready.
pub(crate) const READY: u32 = 1 << 10 | 1 << 17 | 1 << 25;
/// Bits of the control that only a reset clears: that of the watch.
pub(crate) const KEPT: u32 = 1 << 19;
/// Reserved bits of the PLL's factors: none is kept.
pub(crate) const RESERVED: u32 = 0;
/// Clears the flags of the reset's cause.
pub(crate) const RMVF: u32 = 1 << 23;
/// The number of the internal oscillator among the sources; the external one and the PLL follow.
pub(crate) const FIRST_SOURCE: u32 = 1;

/// Ticks of 85 MHz, and so reads, in the microsecond that begins with half of the clock (PWR).
const HALVED_TICKS: u32 = 85;

/// The highest frequency without the boost, Hz (PWR).
const NORMAL: f64 = 150e6;

pub(crate) struct Own {
    /// The core's voltage is boosted.
    pub(crate) is_boosted: Cell<bool>,
    /// Reads since the clock was switched.
    since_switch: Cell<u32>,
}

impl Default for Own {
    fn default() -> Self {
        Self {
            is_boosted: Cell::new(false),
            since_switch: Cell::new(u32::MAX),
        }
    }
}

impl Own {
    pub(crate) fn tick(&self) {
        let reads = self.since_switch.get().saturating_add(1);
        self.since_switch.set(reads);
    }

    pub(crate) fn configured(&self, _: u32) {}

    pub(crate) fn switched(&self) {
        self.since_switch.set(0);
    }
}

impl Clocks {
    pub(crate) fn set_others_after_reset(rcc: &Block<rcc::RegisterBlock>) {
        rcc.set(rcc.pllcfgr(), 0x1000);
        rcc.set(rcc.csr(), 0x0c00_0000);
        rcc.set(rcc.ahb1enr(), 0x100);
        rcc.set(rcc.apb1enr1(), 0x400);
    }

    /// The registers that switch clocks on.
    pub(crate) fn enables(&self) -> [u32; 4] {
        let rcc = &self.rcc;
        [
            rcc.address(rcc.ahb1enr()),
            rcc.address(rcc.ahb2enr()),
            rcc.address(rcc.apb1enr1()),
            rcc.address(rcc.apb2enr()),
        ]
    }

    /// True if the watchdog reset the chip.
    pub(crate) fn blames_watchdog(&self) -> bool {
        self.rcc.csr().read().iwdgrstf().bit()
    }

    /// The PLL's output R, Hz (RCC).
    pub(crate) fn pll(&self) -> f64 {
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

    pub(crate) fn check(&self) {
        let processor = self.frequencies().processor;
        assert!(processor <= 170e6, "the processor runs at {processor} Hz");
        if self.source() > NORMAL {
            assert!(
                self.own.is_boosted.get(),
                "{processor} Hz without the boost"
            );
            let is_half = processor <= self.source() / 2.0;
            assert!(
                is_half || self.own.since_switch.get() >= HALVED_TICKS,
                "the first microsecond takes half of the clock (PWR)"
            );
        }
    }

    /// Sets whether the core's voltage is boosted.
    pub(crate) fn boost(&self, boosted: bool) {
        self.own.is_boosted.set(boosted);
        self.check();
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
