//! ADC1 and what it shares with ADC2 (RM0440, ADC).

use std::cell::Cell;

use super::block::Block;
use super::clocks::{Clocks, Peripheral};
use super::pins::{Mode, Pins};
use crate::pac::{ADC1, ADC12_COMMON, adc1, adc12_common};

/// Reads from the regulator's start until it is stable: 20 µs at 170 MHz (data sheet).
const REGULATED_READS: u32 = 3400;

/// Reads of a register until a ready bit changes.
const WAIT: u32 = 4;

/// Reads from the end of a calibration on that the start must wait: four ticks of the converter (ADC).
const CALIBRATED_READS: u32 = 16;

pub(crate) struct Adc {
    adc1: Block<adc1::RegisterBlock>,
    common: Block<adc12_common::RegisterBlock>,
    /// The voltage at PA1, V.
    pub(crate) pin: Cell<f64>,
    /// Reads since the last step of the start.
    reads: Cell<u32>,
    is_calibrated: Cell<bool>,
    /// Conversions began.
    begun: Cell<bool>,
}

impl Adc {
    pub(crate) fn new() -> Self {
        let adc = Self {
            adc1: Block::at(ADC1::ptr()),
            common: Block::at(ADC12_COMMON::ptr()),
            pin: Cell::new(1.65),
            reads: Cell::new(0),
            is_calibrated: Cell::new(false),
            begun: Cell::new(false),
        };
        adc.reset();
        adc
    }

    pub(crate) fn reset(&self) {
        self.adc1.clear();
        self.common.clear();
        // Powered down deeply (ADC), and without a queue of injected channels (ADC).
        self.adc1.set(self.adc1.cr(), 1 << 29);
        self.adc1.set(self.adc1.cfgr(), 1 << 31);
        self.begun.set(false);
        self.is_calibrated.set(false);
    }

    pub(crate) fn find(&self, address: u32) -> Option<(Peripheral, &Cell<u32>)> {
        let word = self.adc1.word(address);
        word.or_else(|| self.common.word(address))
            .map(|word| (Peripheral::Adc1, word))
    }

    /// Ticks of a conversion's sampling and the converter's frequency, Hz.
    pub(crate) fn sampling(&self, clocks: &Clocks) -> (f64, f64) {
        const TICKS: [f64; 8] = [2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5];
        let divider = match self.common.ccr().read().ckmode().bits() {
            0 => panic!("it has no clock"),
            mode => f64::from(1 << (mode - 1)),
        };
        let ticks = TICKS[usize::from(self.adc1.smpr1().read().smp2().bits())];
        (ticks, clocks.frequencies().processor / divider)
    }

    /// The newest conversion of channel 2, if it converts that without a pause; the pin must be an analogue one.
    pub(crate) fn read(&self, address: u32, word: &Cell<u32>, pins: &Pins) -> u32 {
        let adc = &self.adc1;
        let reads = self.reads.get().saturating_add(1);
        self.reads.set(reads);
        if address == adc.address(adc.cr()) && adc.cr().read().adcal().bit() && reads > WAIT {
            adc.set(adc.cr(), adc.get(adc.cr()) & !(1 << 31));
            self.is_calibrated.set(true);
            self.reads.set(0);
        } else if address == adc.address(adc.isr()) && adc.cr().read().aden().bit() && reads > WAIT
        {
            adc.set(adc.isr(), adc.get(adc.isr()) | 1);
            assert!(adc.isr().read().adrdy().bit());
        }
        if address != adc.address(adc.dr()) {
            return word.get();
        }
        let (settings, sequence) = (adc.cfgr().read(), adc.sqr1().read());
        let converts = self.begun.get()
            && settings.cont().bit()
            && settings.ovrmod().bit()
            && settings.res().bits() == 0
            && !settings.align().bit()
            && sequence.l().bits() == 0
            && sequence.sq1().bits() == 2
            && pins.mode(0, 1) == Mode::Analog;
        if converts {
            (self.pin.get() / 3.3 * 4096.0).clamp(0.0, 4095.0) as u32
        } else {
            0
        }
    }

    pub(crate) fn write(&self, address: u32, word: &Cell<u32>, new: u32, clocks: &Clocks) {
        let adc = &self.adc1;
        if address == adc.address(adc.isr()) {
            // Ones clear.
            word.set(word.get() & !new);
            return;
        }
        if address != adc.address(adc.cr()) {
            assert!(!self.begun.get(), "it converts (ADC)");
            word.set(new);
            return;
        }
        let before = adc.cr().read();
        // Software sets what hardware clears.
        let kept = 0b1_1111 | 1 << 31;
        word.set(word.get() & kept | new);
        let after = adc.cr().read();
        let reads = self.reads.get();
        if after.deeppwd().bit() {
            assert!(!after.advregen().bit(), "powered down deeply (ADC)");
        } else if after.advregen().bit() && before.deeppwd().bit() {
            panic!("the regulator starts after the deep power-down has ended (ADC)");
        }
        if after.advregen().bit() && !before.advregen().bit() {
            self.reads.set(0);
        }
        if after.adcal().bit() && !before.adcal().bit() {
            assert!(before.advregen().bit() && reads >= REGULATED_READS, "20 µs");
            assert!(!after.aden().bit(), "it is enabled (ADC)");
            self.reads.set(0);
        }
        if after.aden().bit() && !before.aden().bit() {
            let waited = self.is_calibrated.get() && reads >= CALIBRATED_READS;
            assert!(waited, "not calibrated, or within four ticks (ADC)");
            let (_, frequency) = self.sampling(clocks);
            assert!(frequency <= 60e6, "it runs at {frequency} Hz (data sheet)");
            self.reads.set(0);
        }
        if after.adstart().bit() && !before.adstart().bit() {
            assert!(adc.isr().read().adrdy().bit(), "it is not ready (ADC)");
            self.begun.set(true);
        }
    }
}
