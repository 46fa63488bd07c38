//! The supply with its detector (RM0440, PWR and EXTI), what breaks the PWM besides the fault line (SYSCFG, DAC and COMP), and
//! what runs while a debugger halts the processor (DBG).

use std::cell::Cell;

use super::block::Block;
use super::clocks::Peripheral;
use super::pins::{Mode, Pins};
use super::timers::Timers;
use crate::pac::{COMP, DAC3, DBGMCU, EXTI, PWR, SYSCFG, comp, dac1, dbgmcu, exti, pwr, syscfg};
use crate::shared::model::clocks::Clocks;

pub(crate) struct Supply {
    pwr: Block<pwr::RegisterBlock>,
    exti: Block<exti::RegisterBlock>,
    dbgmcu: Block<dbgmcu::RegisterBlock>,
    syscfg: Block<syscfg::RegisterBlock>,
    comp: Block<comp::RegisterBlock>,
    dac: Block<dac1::RegisterBlock>,
    /// V.
    voltage: Cell<f64>,
    /// The voltage of the current at PA0, V.
    pub(crate) sensed: Cell<f64>,
    /// The processor is locked up.
    pub(crate) is_locked_up: Cell<bool>,
    /// Reads since the comparator was enabled.
    reads: Cell<u32>,
}

/// The highest threshold of the supply by its number, V; the next number is a voltage at a pin (PWR).
const HIGHEST: (u8, f64) = (0b110, 2.9);

/// The detector's line among the external interrupts (EXTI).
const LINE: u32 = 16;

/// Reads until DAC and comparator are settled: 20 µs at 170 MHz (data sheet).
const SETTLED_READS: u32 = 3400;

impl Supply {
    pub(crate) fn new() -> Self {
        let supply = Self {
            pwr: Block::at(PWR::ptr()),
            exti: Block::at(EXTI::ptr()),
            dbgmcu: Block::at(DBGMCU::ptr()),
            syscfg: Block::at(SYSCFG::ptr()),
            comp: Block::at(COMP::ptr()),
            dac: Block::at(DAC3::ptr()),
            voltage: Cell::new(3.3),
            sensed: Cell::new(0.1),
            is_locked_up: Cell::new(false),
            reads: Cell::new(0),
        };
        // Without the boost (PWR).
        supply.pwr.set(supply.pwr.cr5(), 1 << 8);
        supply
    }

    pub(crate) fn reset(&self) {
        self.comp.clear();
        self.dac.clear();
    }

    /// Sets the voltage, V.
    pub(crate) fn set(&self, voltage: f64) {
        let was_low = self.is_low();
        self.voltage.set(voltage);
        self.look(was_low);
    }

    /// The detector's output.
    fn is_low(&self) -> bool {
        let control = self.pwr.cr2().read();
        let (number, threshold) = HIGHEST;
        control.pvde().bit() && control.pvdls().bits() == number && self.voltage.get() < threshold
    }

    /// An edge of the detector's output is kept.
    fn look(&self, was_low: bool) {
        let rises = self.exti.get(self.exti.rtsr1()) >> LINE & 1 != 0;
        if !was_low && self.is_low() && rises {
            let pending = self.exti.get(self.exti.pr1());
            self.exti.set(self.exti.pr1(), pending | 1 << LINE);
        }
    }

    /// True if the detector's interrupt is requested.
    pub(crate) fn interrupts(&self) -> bool {
        let bits = self.exti.get(self.exti.pr1()) & self.exti.get(self.exti.imr1());
        bits >> LINE & 1 != 0
    }

    /// A debugger has the watchdog and TIM1 stand still while the processor is halted.
    pub(crate) fn freeze(&self) {
        self.dbgmcu.set(self.dbgmcu.apb1l_fz(), u32::MAX);
        self.dbgmcu.set(self.dbgmcu.apb2_fz(), u32::MAX);
    }

    /// True if the watchdog, and TIM1, stand still with the processor.
    pub(crate) fn is_frozen(&self) -> [bool; 2] {
        [
            self.dbgmcu.apb1l_fz().read().dbg_iwdg_stop().bit(),
            self.dbgmcu.apb2_fz().read().dbg_tim1_stop().bit(),
        ]
    }

    /// The threshold of the current, V, once the DAC drives it to the comparator.
    pub(crate) fn threshold(&self) -> Option<f64> {
        let (control, mode) = (self.dac.cr().read(), self.dac.mcr().read());
        let drives = control.en(0).bit()
            && !control.ten(0).bit()
            && mode.mode(0).bits() == 0b011
            && mode.hfsel().bits() == 0b10;
        let code = self.dac.dhr12r(0).read().daccdhr().bits();
        drives.then_some(f64::from(code) / 4096.0 * self.voltage.get())
    }

    /// True if the comparator, with PA0 and channel 1 of DAC3 as its inputs, breaks the PWM.
    pub(crate) fn current_breaks(&self, pins: &Pins, timers: &Timers) -> bool {
        let control = self.comp.ccsr(2).read();
        let compares = control.en().bit()
            && control.inmsel().bits() == 0b100
            && !control.inpsel().bit()
            && !control.pol().bit()
            && control.blanksel().bits() == 0
            && pins.mode(0, 0) == Mode::Analog;
        let routes = timers.tim1.af1().read();
        let breaks = routes.bkcmp3e().bit() && !routes.bkcmp3p().bit();
        if breaks {
            assert!(
                self.reads.get() >= SETTLED_READS,
                "the comparator breaks before it is settled"
            );
        }
        let threshold = self.threshold();
        breaks && compares && threshold.is_some_and(|threshold| self.sensed.get() > threshold)
    }

    /// True if the supply's detector or a processor that is locked up breaks the PWM.
    pub(crate) fn breaks_by_itself(&self) -> bool {
        let locks = self.syscfg.cfgr2().read();
        locks.pvdl().bit() && self.is_low() || locks.cll().bit() && self.is_locked_up.get()
    }

    fn word(&self, address: u32, clocks: &Clocks) -> Option<&Cell<u32>> {
        for (word, peripheral) in [
            (self.pwr.word(address), Peripheral::Pwr),
            (self.syscfg.word(address), Peripheral::Syscfg),
            (self.comp.word(address), Peripheral::Syscfg),
            (self.dac.word(address), Peripheral::Dac3),
        ] {
            if word.is_some() {
                assert!(clocks.reaches(peripheral), "{peripheral:?} is off");
                return word;
            }
        }
        self.exti
            .word(address)
            .or_else(|| self.dbgmcu.word(address))
    }

    pub(crate) fn read(&self, address: u32, clocks: &Clocks) -> Option<u32> {
        let word = self.word(address, clocks)?;
        self.reads.set(self.reads.get().saturating_add(1));
        if address == self.pwr.address(self.pwr.sr2()) {
            word.set(u32::from(self.is_low()) << 11);
            assert_eq!(self.pwr.sr2().read().pvdo().bit(), self.is_low());
        }
        Some(word.get())
    }

    pub(crate) fn write(&self, address: u32, new: u32, clocks: &Clocks) -> bool {
        let Some(word) = self.word(address, clocks) else {
            return false;
        };
        let was_low = self.is_low();
        let was_on = self.dac.cr().read().en(0).bit();
        if address == self.exti.address(self.exti.pr1()) {
            // Ones clear.
            word.set(word.get() & !new);
        } else if address == self.pwr.address(self.pwr.cr2())
            && self.syscfg.cfgr2().read().pvdl().bit()
        {
            // Its settings are kept until a reset (SYSCFG).
            word.set(new & !0xf | word.get() & 0xf);
        } else if address == self.syscfg.address(self.syscfg.cfgr2()) {
            // Only a reset takes them away.
            word.set(word.get() | new);
        } else {
            word.set(new);
        }
        if address == self.pwr.address(self.pwr.cr5()) {
            clocks.boost(!self.pwr.cr5().read().r1mode().bit());
        } else if address == self.dac.address(self.dac.mcr()) {
            assert!(!was_on, "the DAC is enabled (DAC)");
        } else if address == self.comp.address(self.comp.ccsr(2)) {
            self.reads.set(0);
        }
        self.look(was_low);
        true
    }
}
