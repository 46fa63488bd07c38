//! TIM4 as the counter of step pulses with a direction.
//!
//! A timer of this family counts pulses one way only. So it counts all of them, and captures its count at every edge of
//! the direction line. Each pulse then counts in the direction that it had, however late it is read.

use crate::board::Board;
use crate::family::{Bus, Family};
use crate::pins::Input;
use crate::registers::timer::{self, TIM4};

/// Highest rate of steps, 1/s. A high and a low level each last as long as the filter takes, which delays both lines
/// alike.
#[must_use]
pub const fn max_step_rate<F: Family>() -> f64 {
    0.5 * F::CLOCKS.low_timers as f64 / F::STEP_FILTER.ticks as f64
}

/// TIM4, which counts the rising edges of the step line. It must be read before 32 767 of them have come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepInput<B> {
    bus: B,
    line: Input<B>,
    count: u16,
    /// The direction after the last edge of it that was read: high.
    is_high: bool,
    /// The line had the other level when it was last read, and no edge was captured.
    disagrees: bool,
}

impl<B: Bus> StepInput<B> {
    /// From a timer in its reset state.
    pub(crate) fn new(bus: B, board: &Board<B::Family>) -> Self {
        let [_, direction] = board.step;
        let lines = timer::CCMR1_CC1S_TI1 | timer::CCMR1_CC2S_TI2;
        let filter = B::Family::STEP_FILTER.bits;
        let filters = filter << timer::CCMR1_IC1F | filter << timer::CCMR1_IC2F;
        bus.write(TIM4.at(timer::CCMR1), lines | filters);
        // Steps by their rising edge, the direction by both.
        let edges = timer::CCER_CC2E | timer::CCER_CC2P | timer::CCER_CC2NP;
        bus.write(TIM4.at(timer::CCER), edges);
        // External clock mode 1 (RM0090, 18.3.3).
        bus.write(
            TIM4.at(timer::SMCR),
            timer::SMCR_TS_TI1 | timer::SMCR_EXTERNAL,
        );
        bus.write(TIM4.at(timer::ARR), u32::from(u16::MAX));
        bus.write(TIM4.at(timer::CR1), timer::CR1_CEN);
        let line = Input::new(bus, direction);
        Self {
            bus,
            line,
            count: 0,
            is_high: !line.is_low(),
            disagrees: false,
        }
    }

    /// Steps since the last call: those that came while the direction was high, less the others. None if the direction
    /// changed more than once, so that it is not known for each.
    #[must_use]
    pub fn steps(&mut self) -> Option<i16> {
        let bus = self.bus;
        let count = bus.read(TIM4.at(timer::CNT)) as u16;
        let status = bus.read(TIM4.at(timer::SR));
        if status & timer::SR_CC2OF != 0 {
            return self.restart(count);
        }
        let mut steps = count.wrapping_sub(self.count).cast_signed();
        if status & timer::SR_CC2IF != 0 {
            // Reading it clears the flag. An edge after the count was read has captured a later one, which the next
            // call makes up for.
            let changed_at = bus.read(TIM4.at(timer::CCR2)) as u16;
            let before = changed_at.wrapping_sub(self.count).cast_signed();
            // Those before less those after, by the direction before.
            steps = before.wrapping_add(before).wrapping_sub(steps);
            if !self.is_high {
                steps = steps.wrapping_neg();
            }
            (self.is_high, self.disagrees) = (!self.is_high, false);
        } else {
            if !self.is_high {
                steps = steps.wrapping_neg();
            }
            // For the time of the filter the line is ahead of its captured edge, and no longer.
            let is_other = self.line.is_low() == self.is_high;
            if is_other && self.disagrees {
                return self.restart(count);
            }
            self.disagrees = is_other;
        }
        self.count = count;
        Some(steps)
    }

    /// Counts from now on, by the level of the direction line.
    #[cold]
    fn restart(&mut self, count: u16) -> Option<i16> {
        let bus = self.bus;
        let _ = bus.read(TIM4.at(timer::CCR2));
        // Ones leave the other flags.
        bus.write(TIM4.at(timer::SR), !(timer::SR_CC2OF | timer::SR_CC2IF));
        self.count = count;
        (self.is_high, self.disagrees) = (!self.line.is_low(), false);
        None
    }
}
