//! The supply with its detector (RM0090, 5 and 12), and what runs while a debugger halts the processor (38.16).

use std::cell::Cell;

use stm32f4::stm32f405::{DBGMCU, EXTI, PWR, dbgmcu, exti, pwr};

use super::block::Block;
use super::pins::Pins;
use super::timers::Timers;
use crate::shared::model::clocks::Clocks;

pub(crate) struct Supply {
    pwr: Block<pwr::RegisterBlock>,
    exti: Block<exti::RegisterBlock>,
    dbgmcu: Block<dbgmcu::RegisterBlock>,
    /// V.
    voltage: Cell<f64>,
}

/// The highest threshold by its number, V.
const HIGHEST: (u8, f64) = (0b111, 2.9);

/// The detector's line among the external interrupts (12.2.5).
const LINE: u32 = 16;

impl Supply {
    pub(crate) fn new() -> Self {
        Self {
            pwr: Block::at(PWR::ptr()),
            exti: Block::at(EXTI::ptr()),
            dbgmcu: Block::at(DBGMCU::ptr()),
            voltage: Cell::new(3.3),
        }
    }

    /// Sets the voltage, V.
    pub(crate) fn set(&self, voltage: f64) {
        let was_low = self.is_low();
        self.voltage.set(voltage);
        self.look(was_low);
    }

    /// The detector's output.
    fn is_low(&self) -> bool {
        let control = self.pwr.cr().read();
        let (number, threshold) = HIGHEST;
        control.pvde().bit() && control.pls().bits() == number && self.voltage.get() < threshold
    }

    /// An edge of the detector's output is kept.
    fn look(&self, was_low: bool) {
        let rises = self.exti.rtsr().read().tr16().is_enabled();
        if !was_low && self.is_low() && rises {
            let pending = self.exti.get(self.exti.pr());
            self.exti.set(self.exti.pr(), pending | 1 << LINE);
        }
    }

    /// True if the detector's interrupt is requested.
    pub(crate) fn interrupts(&self) -> bool {
        self.exti.pr().read().pr16().is_pending() && self.exti.imr().read().mr16().is_unmasked()
    }

    /// A debugger has the watchdog and TIM1 stand still while the processor is halted.
    pub(crate) fn freeze(&self) {
        self.dbgmcu.set(self.dbgmcu.apb1_fz(), u32::MAX);
        self.dbgmcu.set(self.dbgmcu.apb2_fz(), u32::MAX);
    }

    /// True if the watchdog, and TIM1, stand still with the processor.
    pub(crate) fn is_frozen(&self) -> [bool; 2] {
        [
            self.dbgmcu.apb1_fz().read().dbg_iwdg_stop().bit(),
            self.dbgmcu.apb2_fz().read().dbg_tim1_stop().bit(),
        ]
    }

    /// True if the voltage of the current breaks the PWM: there is no comparator.
    pub(crate) fn current_breaks(&self, _: &Pins, _: &Timers) -> bool {
        false
    }

    /// True if the chip itself breaks the PWM, which is for the processor to do.
    pub(crate) fn breaks_by_itself(&self) -> bool {
        false
    }

    fn word(&self, address: u32, clocks: &Clocks) -> Option<&Cell<u32>> {
        if let Some(word) = self.pwr.word(address) {
            assert!(
                clocks.rcc.apb1enr().read().pwren().is_enabled(),
                "the clock of PWR is off"
            );
            return Some(word);
        }
        self.exti
            .word(address)
            .or_else(|| self.dbgmcu.word(address))
    }

    pub(crate) fn read(&self, address: u32, clocks: &Clocks) -> Option<u32> {
        let word = self.word(address, clocks)?;
        if address == self.pwr.address(self.pwr.csr()) {
            word.set(u32::from(self.is_low()) << 2);
            assert_eq!(self.pwr.csr().read().pvdo().bit(), self.is_low());
        }
        Some(word.get())
    }

    pub(crate) fn write(&self, address: u32, new: u32, clocks: &Clocks) -> bool {
        let Some(word) = self.word(address, clocks) else {
            return false;
        };
        let was_low = self.is_low();
        if address == self.exti.address(self.exti.pr()) {
            // Ones clear.
            word.set(word.get() & !new);
        } else {
            word.set(new);
        }
        self.look(was_low);
        true
    }
}
