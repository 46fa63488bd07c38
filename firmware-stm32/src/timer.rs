//! The timer whose update is a sample.

use stm32f4xx_hal::pac::TIM5;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::clock::Clocks;

/// TIM5, 32 bits, interrupting at every sample.
pub struct SampleTimer {
    registers: TIM5,
    clock: u32,
}

impl SampleTimer {
    /// Stands still.
    #[must_use]
    pub fn new(registers: TIM5, clocks: &Clocks, rcc: &mut Rcc) -> Self {
        TIM5::enable(rcc);
        TIM5::reset(rcc);
        Self {
            registers,
            clock: clocks.low_timers,
        }
    }

    /// Runs with a sample time, s; a time that the timer does not reach becomes its nearest.
    pub fn start(&mut self, sample_time: f64) {
        // A cast saturates.
        let ticks = (f64::from(self.clock) * sample_time + 0.5) as u32;
        self.registers
            .arr()
            .write(|write| write.arr().set(ticks.max(2) - 1));
        self.registers.egr().write(|write| write.ug().set_bit());
        self.registers.sr().write(|write| write.uif().clear_bit());
        self.registers.dier().write(|write| write.uie().set_bit());
        self.registers.cr1().write(|write| write.cen().set_bit());
    }

    /// Begins a sample; the next one is then [`SampleTimer::is_due`] only once its time has come.
    #[inline]
    pub fn acknowledge() {
        // SAFETY: the flag is cleared by nobody but the interrupt.
        let registers = unsafe { TIM5::steal() };
        registers.sr().write(|write| write.uif().clear_bit());
    }

    /// Whether the time of the next sample has come.
    #[inline]
    #[must_use]
    pub fn is_due() -> bool {
        // SAFETY: read only.
        let registers = unsafe { TIM5::steal() };
        registers.sr().read().uif().bit_is_set()
    }
}
