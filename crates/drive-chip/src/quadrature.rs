//! TIM3 as the counter of an encoder.

use core::convert::Infallible;

use identifier_core::drive::PositionSensor;
use identifier_core::measurement::Counter;

use crate::family::{Bus, Family};
use crate::registers::timer::{self, TIM3};

/// Highest rate of counts, 1/s. Each level of two lines with both edges lasts as long as the filter takes, which is
/// longer than the PWM's edges ring.
#[must_use]
pub const fn max_count_rate<F: Family>() -> f64 {
    2.0 * F::CLOCKS.low_timers as f64 / F::ENCODER_FILTER.ticks as f64
}

/// TIM3, which counts both edges of both lines in 16 bits, and captures its count at the index pulse.
///
/// It must be read before the servo has moved by half its range. No servo reaches 32 767 counts a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadrature<B> {
    bus: B,
    counter: Counter<u16>,
}

impl<B: Bus> Quadrature<B> {
    /// Counts from zero at any position of the servo, from a timer in its reset state.
    pub(crate) fn new(bus: B) -> Self {
        let lines = timer::CCMR1_CC1S_TI1 | timer::CCMR1_CC2S_TI2;
        let filter = B::Family::ENCODER_FILTER.bits;
        let filters = filter << timer::CCMR1_IC1F | filter << timer::CCMR1_IC2F;
        bus.write(TIM3.at(timer::CCMR1), lines | filters);
        let index = timer::CCMR2_CC3S_TI3 | filter << timer::CCMR2_IC3F;
        bus.write(TIM3.at(timer::CCMR2), index);
        bus.write(TIM3.at(timer::CCER), timer::CCER_CC3E);
        bus.write(TIM3.at(timer::SMCR), timer::SMCR_ENCODER_3);
        bus.write(TIM3.at(timer::ARR), u32::from(u16::MAX));
        bus.write(TIM3.at(timer::CR1), timer::CR1_CEN);
        Self {
            bus,
            counter: Counter::new(register(bus)),
        }
    }

    /// The count that the timer captured at the last index pulse, if there was one since the last call.
    #[must_use]
    pub fn index(&self) -> Option<i32> {
        let bus = self.bus;
        if bus.read(TIM3.at(timer::SR)) & timer::SR_CC3IF == 0 {
            return None;
        }
        // Reading it clears the flag.
        Some(self.counter.at(bus.read(TIM3.at(timer::CCR3)) as u16))
    }
}

fn register(bus: impl Bus) -> u16 {
    bus.read(TIM3.at(timer::CNT)) as u16
}

impl<B: Bus> PositionSensor for Quadrature<B> {
    type Error = Infallible;

    #[inline]
    fn count(&mut self) -> Result<i32, Infallible> {
        Ok(self.counter.read(register(self.bus)))
    }
}
