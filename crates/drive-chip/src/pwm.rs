//! TIM1 as an output of magnitude and sign that a fault line disables in hardware. The first channel is a PWM. The
//! second is its direction, a level that changes with a period, like the duty.

use core::convert::Infallible;

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{ErrorType, SetDutyCycle};

use crate::clock::Clocks;
use crate::family::{Bus, Family};
use crate::registers::timer;
use crate::supply;

/// Switching frequency, Hz: inaudible.
pub const FREQUENCY: u32 = 20_000;

/// A switching period, s.
pub const PERIOD: f64 = 1.0 / FREQUENCY as f64;

/// Off. The break input is on and active high. The timer drives the output to its idle state, low, and does not let it
/// float (OSSI; RM0090, table 98). The first write locks the bits of breaks until a reset (RM0090, 17.4.18). No output
/// returns by itself after a break (AOE).
const OFF: u32 =
    timer::BDTR_BKE | timer::BDTR_BKP | timer::BDTR_OSSR | timer::BDTR_OSSI | timer::BDTR_LOCK_1;

/// TIM1, channel 1. After a break, hardware keeps the output off until it is switched off and then a duty is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pwm<B> {
    bus: B,
    steps: u16,
    /// A duty was set since it was switched off.
    is_on: bool,
}

/// TIM1, complementary output of channel 2: high for all of a period, or low. Low while the PWM is switched off.
///
/// A level waits for the duty that is set after it, and both take effect with the same period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Direction<B> {
    bus: B,
    steps: u16,
}

/// Magnitude, off, and sign, from a timer in its reset state. They count once the sample timer is started.
pub(crate) fn signed<B: Bus>(bus: B, clocks: &Clocks) -> (Pwm<B>, Direction<B>) {
    let steps = (clocks.high_timers / FREQUENCY) as u16;
    bus.write(
        B::Family::TIM1.at(timer::ARR),
        u32::from(steps.saturating_sub(1)),
    );
    // PWM mode 1 with preload (RM0090, 17.3.9): what is set takes effect with the next period.
    bus.write(
        B::Family::TIM1.at(timer::CCMR1),
        timer::CCMR1_OC1PE | timer::CCMR1_OC1M_PWM_1 | timer::CCMR1_OC2PE | timer::CCMR1_OC2M_PWM_1,
    );
    bus.write(
        B::Family::TIM1.at(timer::CCER),
        timer::CCER_CC1E | timer::CCER_CC2NE,
    );
    bus.write(B::Family::TIM1.at(timer::BDTR), OFF);
    bus.write(B::Family::TIM1.at(timer::EGR), timer::EGR_UG);
    let pwm = Pwm {
        bus,
        steps,
        is_on: false,
    };
    (pwm, Direction { bus, steps })
}

impl<B> digital::ErrorType for Direction<B> {
    type Error = Infallible;
}

impl<B: Bus> Direction<B> {
    #[inline]
    fn set_high_for(&self, steps: u16) {
        // No period may begin with the new direction and the old duty (UDIS; RM0090, 17.4.1).
        self.bus
            .modify(B::Family::TIM1.at(timer::CR1), 0, timer::CR1_UDIS);
        self.bus
            .write(B::Family::TIM1.at(timer::CCR2), u32::from(steps));
    }
}

impl<B: Bus> OutputPin for Direction<B> {
    #[inline]
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set_high_for(0);
        Ok(())
    }

    #[inline]
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set_high_for(self.steps);
        Ok(())
    }
}

/// Has the next period begin with what was set.
#[inline]
fn take_effect<B: Bus>(bus: B) {
    bus.modify(B::Family::TIM1.at(timer::CR1), timer::CR1_UDIS, 0);
}

impl<B> ErrorType for Pwm<B> {
    type Error = Infallible;
}

impl<B: Bus> SetDutyCycle for Pwm<B> {
    #[inline]
    fn max_duty_cycle(&self) -> u16 {
        self.steps
    }

    #[inline]
    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.bus.write(
            B::Family::TIM1.at(timer::CCR1),
            u32::from(duty.min(self.steps)),
        );
        take_effect(self.bus);
        // Only once: a break may have disabled it since.
        if !core::mem::replace(&mut self.is_on, true) {
            self.bus
                .write(B::Family::TIM1.at(timer::BDTR), OFF | timer::BDTR_MOE);
        }
        Ok(())
    }

    #[inline]
    fn set_duty_cycle_fully_off(&mut self) -> Result<(), Infallible> {
        off(self.bus);
        self.is_on = false;
        self.bus.write(B::Family::TIM1.at(timer::CCR1), 0);
        take_effect(self.bus);
        // Acknowledged: the next break and the next sag show again. Ones leave the other flags.
        self.bus
            .write(B::Family::TIM1.at(timer::SR), !B::Family::BREAKS);
        supply::acknowledge(self.bus);
        Ok(())
    }
}

/// Drives both outputs low, whatever the timer's state.
#[inline]
pub(crate) fn off<B: Bus>(bus: B) {
    bus.write(B::Family::TIM1.at(timer::BDTR), OFF);
}

/// True if a break has disabled the output since it was last switched off.
#[inline]
pub(crate) fn broke<B: Bus>(bus: B) -> bool {
    bus.read(B::Family::TIM1.at(timer::SR)) & B::Family::BREAKS != 0
}
