//! ADC1 as the input of a command of ±10 V.
//!
//! Three resistors at the pin bring ±11 V to its range: 66.5 kΩ from the command, 20 kΩ from 3.3 V, 28.7 kΩ to ground.
//! The pin is at 1.65 V for 0 V, and 0.15 V higher per volt; an open wire reads as 2 V.

use crate::bus::Bus;
use crate::registers::adc;

/// The code of 0 V.
const ZERO: f32 = 2048.0;

/// Codes per 10 V: 1.5 V of 3.3 V in 4096.
const PER_10_V: f32 = 4096.0 * 1.5 / 3.3;

/// The largest voltage that is a command, parts of 10 V.
const MAX: f32 = 1.05;

/// Reads until the converter is stable, 3 µs (STM32F405 data sheet, table 67).
const STABLE_READS: u32 = 600;

/// ADC1, which converts without a pause: 23 µs each, at the longest sampling time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnalogueInput<B> {
    bus: B,
}

impl<B: Bus> AnalogueInput<B> {
    /// Converting, from a converter in its reset state.
    pub(crate) fn new(bus: B) -> Self {
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
        Self { bus }
    }

    /// The voltage, parts of 10 V; none beyond 10.5 V.
    #[must_use]
    pub fn voltage(&self) -> Option<f32> {
        let code = self.bus.read(adc::DR) & 0xfff;
        let voltage = (code as f32 - ZERO) * (1.0 / PER_10_V);
        (voltage.abs() <= MAX).then_some(voltage)
    }
}
