//! Clocks and resets of the peripherals (RM0090, 7), and what runs while a debugger halts the processor (38.16).

use super::Stm32F4;
use super::registers::{dbgmcu, rcc};
use crate::bus::Register;
use crate::family::{Bus, Peripherals};

impl<const MEGAHERTZ: u32> Peripherals for Stm32F4<MEGAHERTZ> {
    fn was_reset_by_watchdog(bus: impl Bus<Family = Self>) -> bool {
        let by_watchdog = bus.read(rcc::CSR) & rcc::CSR_IWDGRSTF != 0;
        bus.modify(rcc::CSR, 0, rcc::CSR_RMVF);
        by_watchdog
    }

    fn power_peripherals(bus: impl Bus<Family = Self>) {
        let power = |enable: Register, reset: Register, peripherals: u32| {
            bus.modify(enable, 0, peripherals);
            // A peripheral answers two ticks after its clock is on (RM0090, 7.2.13): a read takes them.
            let _ = bus.read(enable);
            bus.modify(reset, 0, peripherals);
            bus.modify(reset, peripherals, 0);
        };
        power(rcc::AHB1ENR, rcc::AHB1RSTR, rcc::AHB1_DMA1);
        power(rcc::APB2ENR, rcc::APB2RSTR, rcc::APB2_TIM1);
        power(
            rcc::APB1ENR,
            rcc::APB1RSTR,
            rcc::APB1_TIM3 | rcc::APB1_TIM4 | rcc::APB1_TIM5 | rcc::APB1_USART2,
        );
    }

    fn run_while_halted(bus: impl Bus<Family = Self>) {
        bus.modify(dbgmcu::APB1_FZ, dbgmcu::APB1_FZ_IWDG, 0);
        bus.modify(dbgmcu::APB2_FZ, dbgmcu::APB2_FZ_TIM1, 0);
    }
}
