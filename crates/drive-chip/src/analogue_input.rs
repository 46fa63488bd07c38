//! ADC1 as the input of a command of ±10 V.
//!
//! Three resistors at the pin bring ±11 V to its range: 66.5 kΩ from the command, 20 kΩ from 3.3 V, 28.7 kΩ to ground.
//! The pin is at 1.65 V for 0 V, and 0.15 V higher per volt; an open wire reads as 2 V.

use crate::family::{Bus, Converter};

/// The code of 0 V.
const ZERO: f32 = 2048.0;

/// Codes per 10 V: 1.5 V of 3.3 V in 4096.
const PER_10_V: f32 = 4096.0 * 1.5 / 3.3;

/// The largest voltage that is a command, parts of 10 V.
const MAX: f32 = 1.05;

/// ADC1, which converts without a pause, at the longest sampling time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnalogueInput<B> {
    bus: B,
}

impl<B: Bus> AnalogueInput<B> {
    /// Converting, from a converter in its reset state.
    pub(crate) fn new(bus: B) -> Self {
        B::Family::start_converter(bus);
        Self { bus }
    }

    /// The voltage, parts of 10 V; none beyond 10.5 V.
    #[must_use]
    pub fn voltage(&self) -> Option<f32> {
        let code = self.bus.read(B::Family::ANALOGUE_CODE) & 0xfff;
        let voltage = (code as f32 - ZERO) * (1.0 / PER_10_V);
        (voltage.abs() <= MAX).then_some(voltage)
    }
}
