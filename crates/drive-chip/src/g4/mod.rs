//! The STM32G474.

mod clock;
mod flash;
mod over_current;
mod reception;
mod registers;
mod reset;
mod supply;

use crate::bus::Register;
use crate::family::{Bus, Family, Functions, InputFilter};
use crate::registers::timer::{self, Timer};
pub use over_current::OverCurrent;
use registers::{exti, rcc, tim1};

/// The family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct G4;

impl Family for G4 {
    type Own = OverCurrent;

    const PORTS: u32 = 0x4800_0000;
    const PORT_CLOCKS: Register = rcc::AHB2ENR;
    /// By the STM32G474's data sheet: of PA8, PB12 and PB14, PC6 to PC8, PB6 and PB7, PA2 and PA3.
    const FUNCTIONS: Functions = Functions {
        tim1: 6,
        tim3: 2,
        tim4: 2,
        usart2: 7,
    };

    const TIM1: Timer = Timer::new(0x4001_2c00);
    const TIM1_BY_TIM5: u32 = tim1::SMCR_TS_ITR4;
    /// Those of the pin and the comparator, and those of the chip: no duty comes through before both are cleared.
    const BREAKS: u32 = timer::SR_BIF | tim1::SR_SBIF;
    /// 282 ns.
    const ENCODER_FILTER: InputFilter = InputFilter::TICKS_48;
    /// 141 ns.
    const STEP_FILTER: InputFilter = InputFilter::TICKS_24;

    const EVENT_MASKS: Register = exti::IMR1;
    const EVENTS: Register = exti::PR1;

    fn wire(bus: impl Bus<Family = Self>, own: &OverCurrent) {
        own.watch(bus);
    }
}
