//! Reset and clock control of the STM32F4 (RM0090, 7).

use std::cell::Cell;

use super::Chip;
use super::block::Block;
use crate::pac::rcc;
use crate::shared::model::clocks::{Clocks, Frequencies, HSI};

/// Values after reset.
pub(crate) const CR: u32 = 0x83;
pub(crate) const CFGR: u32 = 0;

/// Flags of what is ready.
pub(crate) const READY: u32 = 1 << 1 | 1 << 17 | 1 << 25;
/// Bits of the control that only a reset clears.
pub(crate) const KEPT: u32 = 0;
/// Reserved bits of the PLL's factors (7.3.2).
pub(crate) const RESERVED: u32 = 0xf0bc_8000;
/// Clears the flags of the reset's cause.
pub(crate) const RMVF: u32 = 1 << 24;
/// The number of the internal oscillator among the sources; the external one and the PLL follow.
pub(crate) const FIRST_SOURCE: u32 = 0;

/// Ticks, and so reads, until a new prescaler holds.
const PRESCALER_TICKS: u32 = 16;

/// Reads since the prescalers were changed.
pub(crate) struct Own(Cell<u32>);

impl Default for Own {
    fn default() -> Self {
        Self(Cell::new(u32::MAX))
    }
}

impl Own {
    pub(crate) fn tick(&self) {
        self.0.set(self.0.get().saturating_add(1));
    }

    /// Checks a write of the configuration by the bits that change.
    pub(crate) fn configured(&self, changed: u32) {
        let prescalers = 0xf << 4 | 0x3f << 10;
        if changed & prescalers != 0 {
            self.0.set(0);
        }
        assert!(
            changed & 0b11 == 0 || self.0.get() >= PRESCALER_TICKS,
            "the prescalers hold up to 16 ticks after they are written (7.3.3): later than the \
             switch"
        );
    }

    pub(crate) fn switched(&self) {}
}

impl Clocks {
    pub(crate) fn set_others_after_reset(rcc: &Block<rcc::RegisterBlock>) {
        rcc.set(rcc.pllcfgr(), 0x2400_3010);
        rcc.set(rcc.csr(), 0x0e00_0000);
    }

    /// The registers that switch clocks on.
    pub(crate) fn enables(&self) -> [u32; 3] {
        let rcc = &self.rcc;
        [
            rcc.address(rcc.ahb1enr()),
            rcc.address(rcc.apb1enr()),
            rcc.address(rcc.apb2enr()),
        ]
    }

    /// True if the watchdog reset the chip.
    pub(crate) fn blames_watchdog(&self) -> bool {
        self.rcc.csr().read().wdgrstf().is_reset()
    }

    /// The PLL's output, Hz (7.3.2).
    pub(crate) fn pll(&self) -> f64 {
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

    pub(crate) fn check(&self) {
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
