//! The STM32F405 and the STM32F446.

mod clock;
mod converter;
mod flash;
mod reception;
pub(crate) mod registers;
mod reset;
mod supply;

use crate::bus::Register;
use crate::family::{Bus, Family, Flash, Functions, InputFilter, Reception, Usart};
use crate::frequencies::{Clocks, Kind};
use crate::registers::timer::{self, Timer};
use registers::{adc, dma, exti, flash as interface, rcc, usart};

/// The family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct F4;

impl Family for F4 {
    type Own = ();

    const CLOCKS: Clocks = clock::FULL;
    /// It takes 1 to 2 MHz, and its jitter is least at 2 (RM0090, 7.3.2).
    const PLL_INPUT: u32 = 2_000_000;
    const OSCILLATOR: [u32; 2] = [4_000_000, 26_000_000];

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

    const USART: Usart = Usart {
        status: usart::SR,
        transmit: usart::DR,
        divider: usart::BRR,
        control_1: usart::CR1,
        control_3: usart::CR3,
        enable: usart::CR1_UE,
    };
    const RECEPTION: Reception = Reception {
        flags: dma::HISR,
        clear: dma::HIFCR,
        left: dma::S5NDTR,
        round: dma::HTIF5 | dma::TCIF5,
        failed: dma::TEIF5,
        all: dma::HTIF5 | dma::TCIF5 | dma::TEIF5 | dma::DMEIF5 | dma::FEIF5,
    };

    const ANALOGUE_CODE: Register = adc::DR;

    const EVENT_MASKS: Register = exti::IMR;
    const EVENTS: Register = exti::PR;

    const FLASH: Flash = Flash {
        access: interface::ACR,
        keys: interface::KEYR,
        status: interface::SR,
        control: interface::CR,
        errors: interface::SR_ERRORS,
        ended: interface::SR_ENDED,
    };
    /// Words of 32 bits (RM0090, 3.6.2).
    const WRITE_SIZE: usize = 4;
    const RECOGNISES_DAMAGE: bool = false;

    fn reset_clock(bus: impl Bus<Family = Self>) {
        clock::reset(bus);
    }

    fn start_clock(bus: impl Bus<Family = Self>, frequency: u32, kind: Kind) -> Option<()> {
        clock::start(bus, frequency, kind)
    }

    fn was_reset_by_watchdog(bus: impl Bus<Family = Self>) -> bool {
        reset::was_by_watchdog(bus)
    }

    fn power_peripherals(bus: impl Bus<Family = Self>) {
        reset::power_peripherals(bus);
    }

    fn run_while_halted(bus: impl Bus<Family = Self>) {
        reset::run_while_halted(bus);
    }

    fn watch_supply(bus: impl Bus<Family = Self>) {
        supply::watch(bus);
    }

    fn supply_is_low(bus: impl Bus<Family = Self>) -> bool {
        supply::is_low(bus)
    }

    fn resets_in_time(bus: impl Bus<Family = Self>) -> bool {
        supply::resets_in_time(bus)
    }

    fn wire(_: impl Bus<Family = Self>, (): &()) {}

    fn receive_into(bus: impl Bus<Family = Self>, place: u32, length: u32) {
        reception::into_memory(bus, place, length);
    }

    fn clear_reception_errors(bus: impl Bus<Family = Self>) {
        reception::clear_errors(bus);
    }

    fn start_converter(bus: impl Bus<Family = Self>) {
        converter::start(bus);
    }

    fn erase<E>(
        bus: impl Bus<Family = Self>,
        area: u32,
        step: impl FnMut(Register, u32) -> Result<(), E>,
    ) -> Result<(), E> {
        flash::erase(bus, area, step)
    }

    fn program<E>(
        bus: impl Bus<Family = Self>,
        place: Register,
        bytes: &[u8],
        step: impl FnMut(Option<(Register, u32)>, (Register, u32)) -> Result<(), E>,
    ) -> Result<(), E> {
        flash::program(bus, place, bytes, step)
    }

    /// Its one cause is a failed oscillator.
    fn outlives_nmi(_: impl Bus<Family = Self>) -> bool {
        false
    }
}
