//! ADC1 (RM0090, 13).

use super::F4;
use super::registers::adc;
use crate::bus::Register;
use crate::family::{Bus, Converter};

/// Reads until the converter is stable, 3 µs (STM32F405 data sheet, table 67).
const STABLE_READS: u32 = 600;

impl Converter for F4 {
    const ANALOGUE_CODE: Register = adc::DR;

    /// 23 µs each.
    fn start_converter(bus: impl Bus<Family = Self>) {
        // At most 36 MHz: a quarter of 84 MHz (data sheet, table 67).
        bus.write(adc::CCR, adc::CCR_ADCPRE_4);
        bus.write(adc::SMPR2, adc::SMPR2_SMP1_480);
        bus.write(adc::SQR1, adc::SQR1_ONE);
        bus.write(adc::SQR3, adc::CHANNEL);
        bus.write(adc::CR2, adc::CR2_ADON | adc::CR2_CONT);
        for _ in 0..STABLE_READS {
            let _ = bus.read(adc::CR2);
        }
        bus.modify(adc::CR2, 0, adc::CR2_SWSTART);
    }
}
