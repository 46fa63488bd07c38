//! The STM32F405 and the STM32F446, and the STM32F401, which is the same at half of their clock.

mod clock;
mod flash;
mod reception;
pub(crate) mod registers;
mod reset;
mod supply;

use crate::bus::Register;
use crate::family::{Bus, Family, Functions, InputFilter};
use crate::registers::timer::{self, Timer};
use registers::{exti, rcc};

/// The family, by the clock of its processor, MHz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stm32F4<const MEGAHERTZ: u32>;

/// The STM32F405 and the STM32F446.
pub type F4 = Stm32F4<168>;
/// The STM32F401 (RM0368).
pub type F401 = Stm32F4<84>;

impl<const MEGAHERTZ: u32> Family for Stm32F4<MEGAHERTZ> {
    type Own = ();

    const PORTS: u32 = 0x4002_0000;
    const PORT_CLOCKS: Register = rcc::AHB1ENR;
    /// By the STM32F405's data sheet, table 9; those of the STM32F446 are the same.
    const FUNCTIONS: Functions = Functions {
        tim1: 1,
        tim3: 2,
        tim4: 2,
        usart2: 7,
    };

    const TIM1: Timer = Timer::new(0x4001_0000);
    /// Trigger 0 (RM0090, table 94).
    const TIM1_BY_TIM5: u32 = 0;
    const BREAKS: u32 = timer::SR_BIF;
    /// 286 ns.
    const ENCODER_FILTER: InputFilter = InputFilter::TICKS_24;
    /// 143 ns.
    const STEP_FILTER: InputFilter = InputFilter::TICKS_12;

    const EVENT_MASKS: Register = exti::IMR;
    const EVENTS: Register = exti::PR;

    fn wire(_: impl Bus<Family = Self>, (): &()) {}
}
