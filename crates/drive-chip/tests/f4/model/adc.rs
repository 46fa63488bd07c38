//! ADC1 and what the converters share (RM0090, 13).

use std::cell::Cell;

use stm32f4::stm32f405::{ADC_COMMON, ADC1, adc_common, adc1};

use super::block::Block;
use super::clocks::{Clocks, Peripheral};
use super::pins::{Mode, Pins};

/// Reads of a register from power on until the converter is stable: 3 µs at 168 MHz (data sheet, table 67).
const STABLE_READS: u32 = 504;

pub(crate) struct Adc {
    adc1: Block<adc1::RegisterBlock>,
    common: Block<adc_common::RegisterBlock>,
    /// The voltage at PA1, V.
    pub(crate) pin: Cell<f64>,
    /// Reads since it was powered.
    reads: Cell<u32>,
    /// Conversions began.
    begun: Cell<bool>,
}

impl Adc {
    pub(crate) fn new() -> Self {
        Self {
            adc1: Block::at(ADC1::ptr()),
            common: Block::at(ADC_COMMON::ptr()),
            pin: Cell::new(1.65),
            reads: Cell::new(0),
            begun: Cell::new(false),
        }
    }

    pub(crate) fn reset(&self) {
        self.adc1.clear();
        self.common.clear();
        self.begun.set(false);
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let word = self.adc1.word(address);
        word.or_else(|| self.common.word(address))
            .map(|word| (Peripheral::Adc1, word))
    }

    /// Ticks of a conversion's sampling and the converter's frequency, Hz.
    pub(crate) fn sampling(&self, clocks: &Clocks) -> (f64, f64) {
        const TICKS: [f64; 8] = [3.0, 15.0, 28.0, 56.0, 84.0, 112.0, 144.0, 480.0];
        let divider = 2.0 * (f64::from(self.common.ccr().read().adcpre().bits()) + 1.0);
        let ticks = TICKS[usize::from(self.adc1.smpr2().read().smp1().bits())];
        (ticks, clocks.frequencies().high_bus / divider)
    }

    /// The newest conversion of channel 1, if it converts that without a pause; the pin must be an analogue one.
    pub(crate) fn read(&self, address: u32, word: &Cell<u32>, pins: &Pins) -> u32 {
        self.reads.set(self.reads.get().saturating_add(1));
        let adc = &self.adc1;
        if address != adc.address(adc.dr()) {
            return word.get();
        }
        let control = adc.cr2().read();
        let converts = self.begun.get()
            && control.adon().is_enabled()
            && control.cont().is_continuous()
            && adc.sqr1().read().l().bits() == 0
            && adc.sqr3().read().sq1().bits() == 1
            && adc.cr1().read().res().bits() == 0
            && control.align().is_right()
            && pins.mode(0, 1) == Mode::Analog;
        if converts {
            (self.pin.get() / 3.3 * 4096.0).clamp(0.0, 4095.0) as u32
        } else {
            0
        }
    }

    pub(crate) fn write(&self, address: u32, word: &Cell<u32>, new: u32, clocks: &Clocks) {
        let was_on = self.adc1.cr2().read().adon().is_enabled();
        word.set(new);
        let adc = &self.adc1;
        if address != adc.address(adc.cr2()) {
            return;
        }
        let control = adc.cr2().read();
        if !was_on && control.adon().is_enabled() {
            self.reads.set(0);
        }
        if control.swstart().bit() {
            assert!(
                was_on && self.reads.get() >= STABLE_READS,
                "it starts before it is stable (13.3.1)"
            );
            let (_, frequency) = self.sampling(clocks);
            assert!(
                frequency <= 36e6,
                "it runs at {frequency} Hz (data sheet, table 67)"
            );
            self.begun.set(true);
            // Hardware clears it.
            word.set(new & !(1 << 30));
        }
    }
}
