//! Clocks and resets of the peripherals (RM0440, RCC), and what runs while a debugger halts the processor (DBG).

use super::G4;
use super::registers::{dbgmcu, rcc};
use crate::bus::Register;
use crate::family::{Bus, Peripherals};

impl Peripherals for G4 {
    fn was_reset_by_watchdog(bus: impl Bus<Family = Self>) -> bool {
        let by_watchdog = bus.read(rcc::CSR) & rcc::CSR_IWDGRSTF != 0;
        bus.modify(rcc::CSR, 0, rcc::CSR_RMVF);
        by_watchdog
    }

    fn power_peripherals(bus: impl Bus<Family = Self>) {
        let power = |enable: Register, reset: Register, peripherals: u32| {
            bus.modify(enable, 0, peripherals);
            // A peripheral answers two ticks after its clock is on (RM0440, RCC): a read takes them.
            let _ = bus.read(enable);
            bus.modify(reset, 0, peripherals);
            bus.modify(reset, peripherals, 0);
        };
        power(
            rcc::AHB1ENR,
            rcc::AHB1RSTR,
            rcc::AHB1_DMA1 | rcc::AHB1_DMAMUX1,
        );
        power(rcc::AHB2ENR, rcc::AHB2RSTR, rcc::AHB2_DAC3);
        power(
            rcc::APB2ENR,
            rcc::APB2RSTR,
            rcc::APB2_SYSCFG | rcc::APB2_TIM1,
        );
        power(
            rcc::APB1ENR1,
            rcc::APB1RSTR1,
            rcc::APB1_TIM3 | rcc::APB1_TIM4 | rcc::APB1_TIM5 | rcc::APB1_USART2,
        );
    }

    fn run_while_halted(bus: impl Bus<Family = Self>) {
        bus.modify(dbgmcu::APB1FZR1, dbgmcu::APB1FZR1_IWDG, 0);
        bus.modify(dbgmcu::APB2FZR, dbgmcu::APB2FZR_TIM1, 0);
    }
}
