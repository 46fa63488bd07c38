//! The first channel of TIM1 as a PWM whose outputs a fault line takes away in hardware.

use core::convert::Infallible;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stm32f4xx_hal::pac::TIM1;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use crate::clock::Clocks;

/// Switching frequency, Hz: above hearing.
const FREQUENCY: u32 = 20_000;

/// TIM1, channel 1. While its break input is high, and until a duty is set after that, the output is
/// off without the processor's doing.
pub struct Pwm {
    registers: TIM1,
    steps: u16,
}

impl Pwm {
    /// Off.
    #[must_use]
    pub fn new(registers: TIM1, clocks: &Clocks, rcc: &mut Rcc) -> Self {
        TIM1::enable(rcc);
        TIM1::reset(rcc);
        let steps = (clocks.high_timers / FREQUENCY) as u16;
        registers
            .arr()
            .write(|write| write.arr().set(steps.saturating_sub(1)));
        // PWM mode 1 with preload (RM0090, 17.3.9).
        registers
            .ccmr1_output()
            .write(|write| write.oc1pe().set_bit().oc1m().pwm_mode1());
        registers.ccer().write(|write| write.cc1e().set_bit());
        // Off means driven low, not floating.
        registers.bdtr().write(|write| {
            let write = write.bke().set_bit().bkp().set_bit();
            write.ossr().set_bit().ossi().set_bit()
        });
        registers.egr().write(|write| write.ug().set_bit());
        registers
            .cr1()
            .write(|write| write.arpe().set_bit().cen().set_bit());
        Self { registers, steps }
    }
}

impl ErrorType for Pwm {
    type Error = Infallible;
}

impl SetDutyCycle for Pwm {
    #[inline]
    fn max_duty_cycle(&self) -> u16 {
        self.steps
    }

    #[inline]
    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.registers
            .ccr1()
            .write(|write| write.ccr().set(duty.min(self.steps)));
        self.registers
            .bdtr()
            .modify(|_, write| write.moe().set_bit());
        Ok(())
    }

    #[inline]
    fn set_duty_cycle_fully_off(&mut self) -> Result<(), Infallible> {
        self.registers
            .bdtr()
            .modify(|_, write| write.moe().clear_bit());
        self.registers.ccr1().write(|write| write.ccr().set(0));
        // Taken note of by now: the next break shows again.
        self.registers
            .sr()
            .modify(|_, write| write.bif().clear_bit());
        Ok(())
    }
}

/// Whether the break input has taken the outputs away since they were last let go.
#[inline]
#[must_use]
pub fn broke() -> bool {
    // SAFETY: read only.
    let registers = unsafe { TIM1::steal() };
    registers.sr().read().bif().bit_is_set()
}
