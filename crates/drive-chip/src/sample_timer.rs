//! The timer whose update is a sample, in step with the PWM.
//!
//! A sample takes a whole number of PWM periods and begins [`LEAD`] before one of them. A command written within that
//! time takes effect with that period. So the time from a sample to its output is always the same.

use crate::clock::Clocks;
use crate::family::{Bus, Family};
use crate::pwm;
use crate::registers::timer::{self, TIM5};

/// Time from the beginning of a sample to the PWM period of its command, s: a quarter of a period.
pub const LEAD: f64 = 1.0 / (LEADS_PER_PERIOD * pwm::FREQUENCY) as f64;

const LEADS_PER_PERIOD: u32 = 4;

/// The nearest whole number of periods, at least 1.
fn nearest(sample_time: f64) -> u32 {
    // A cast saturates.
    ((sample_time * f64::from(pwm::FREQUENCY) + 0.5) as u32).max(1)
}

/// TIM5, 32 bits, interrupting at every sample; it starts TIM1 too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleTimer<B> {
    bus: B,
    /// Ticks of TIM5 in a PWM period.
    period: u32,
    /// Count of TIM1 when a sample begins, ticks.
    phase: u32,
}

impl<B: Bus> SampleTimer<B> {
    /// Stopped, from a timer in its reset state.
    pub(crate) fn new(bus: B, clocks: &Clocks) -> Self {
        let pwm_period = clocks.high_timers / pwm::FREQUENCY;
        Self {
            bus,
            period: clocks.low_timers / pwm::FREQUENCY,
            phase: pwm_period - pwm_period / LEADS_PER_PERIOD,
        }
    }

    /// Runs with a sample time, s, rounded to a whole number of PWM periods. The output must be disabled
    /// meanwhile: the PWM restarts.
    pub fn start(&self, sample_time: f64) {
        let Self { bus, period, phase } = *self;
        // Only an overflow is a sample, not a counter that is set.
        bus.write(TIM5.at(timer::CR1), timer::CR1_URS);
        bus.modify(B::Family::TIM1.at(timer::CR1), timer::CR1_CEN, 0);
        let ticks = nearest(sample_time).saturating_mul(period);
        bus.write(TIM5.at(timer::ARR), ticks - 1);
        bus.write(TIM5.at(timer::EGR), timer::EGR_UG);
        bus.write(B::Family::TIM1.at(timer::CNT), phase);
        // TIM5's enable triggers TIM1: both start at once, whatever
        // interrupts this.
        bus.write(TIM5.at(timer::CR2), timer::CR2_MMS_ENABLE);
        bus.write(
            B::Family::TIM1.at(timer::SMCR),
            B::Family::TIM1_BY_TIM5 | timer::SMCR_TRIGGER,
        );
        acknowledge(bus);
        bus.write(TIM5.at(timer::DIER), timer::DIER_UIE);
        bus.write(TIM5.at(timer::CR1), timer::CR1_URS | timer::CR1_CEN);
    }
}

/// Begins a sample; the next one follows after the sample time.
#[inline]
pub fn acknowledge(bus: impl Bus) {
    // Ones leave the other flags.
    bus.write(TIM5.at(timer::SR), !timer::SR_UIF);
}

/// True once the time of the next sample has come.
#[inline]
#[must_use]
pub fn is_due(bus: impl Bus) -> bool {
    bus.read(TIM5.at(timer::SR)) & timer::SR_UIF != 0
}
