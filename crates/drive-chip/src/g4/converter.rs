//! ADC1 (RM0440, ADC).

use super::G4;
use super::registers::adc;
use crate::bus::Register;
use crate::family::{Bus, Converter, becomes};

/// Reads until the converter's own regulator is stable, 20 µs at 170 MHz (data sheet).
const REGULATED_READS: u32 = 4_000;

/// Reads for the four ticks of the converter, a quarter of the processor's each, from the calibration to its start
/// (RM0440, ADC).
const CALIBRATED_READS: u32 = 16;

impl Converter for G4 {
    const ANALOGUE_CODE: Register = adc::DR;

    /// 15 µs each. One that does not become ready
    /// shows the code 0, which is no command.
    fn start_converter(bus: impl Bus<Family = Self>) {
        let wait = |reads| {
            for _ in 0..reads {
                let _ = bus.read(adc::CR);
            }
        };
        // At most 60 MHz: a quarter of 170 MHz (data sheet).
        bus.write(adc::CCR, adc::CCR_CKMODE_4);
        // After reset it is powered down deeply (RM0440, ADC).
        bus.write(adc::CR, 0);
        bus.write(adc::CR, adc::CR_ADVREGEN);
        wait(REGULATED_READS);
        bus.write(adc::CR, adc::CR_ADVREGEN | adc::CR_ADCAL);
        if becomes(bus, adc::CR, adc::CR_ADCAL, 0).is_none() {
            return;
        }
        wait(CALIBRATED_READS);
        bus.write(adc::CR, adc::CR_ADVREGEN | adc::CR_ADEN);
        if becomes(bus, adc::ISR, adc::ISR_ADRDY, adc::ISR_ADRDY).is_none() {
            return;
        }
        bus.write(adc::SMPR1, adc::SMPR1_SMP2_640);
        bus.write(adc::SQR1, adc::SQR1_CHANNEL_2);
        // The newest conversion replaces one that was not read.
        bus.modify(adc::CFGR, 0, adc::CFGR_CONT | adc::CFGR_OVRMOD);
        // Zeros leave the bits that hardware clears.
        bus.write(adc::CR, adc::CR_ADVREGEN | adc::CR_ADSTART);
    }
}
