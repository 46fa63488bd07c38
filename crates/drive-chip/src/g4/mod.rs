//! The STM32G474.

mod clock;
mod converter;
mod flash;
mod over_current;
mod reception;
mod registers;
mod reset;
mod supply;

use crate::bus::Register;
use crate::family::{Bus, Family, Flash, Functions, InputFilter, Reception, Usart};
use crate::frequencies::{Clocks, Kind};
use crate::registers::timer::{self, Timer};
pub use over_current::OverCurrent;
use registers::{adc, dma, exti, flash as interface, rcc, tim1, usart};

/// The family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct G4;

impl Family for G4 {
    type Own = OverCurrent;

    const CLOCKS: Clocks = clock::FULL;
    /// It takes 2.66 to 16 MHz (RM0440, RCC).
    const PLL_INPUT: u32 = 4_000_000;
    const OSCILLATOR: [u32; 2] = [4_000_000, 48_000_000];

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

    const USART: Usart = Usart {
        status: usart::ISR,
        transmit: usart::TDR,
        divider: usart::BRR,
        control_1: usart::CR1,
        control_3: usart::CR3,
        enable: usart::CR1_UE,
    };
    const RECEPTION: Reception = Reception {
        flags: dma::ISR,
        clear: dma::IFCR,
        left: dma::CNDTR1,
        round: dma::HTIF1 | dma::TCIF1,
        failed: dma::TEIF1,
        all: dma::HTIF1 | dma::TCIF1 | dma::TEIF1,
    };

    const ANALOGUE_CODE: Register = adc::DR;

    const EVENT_MASKS: Register = exti::IMR1;
    const EVENTS: Register = exti::PR1;

    const FLASH: Flash = Flash {
        access: interface::ACR,
        keys: interface::KEYR,
        status: interface::SR,
        control: interface::CR,
        errors: interface::SR_ERRORS,
        ended: interface::SR_ENDED,
    };
    /// Double words of 64 bits (RM0440, FLASH).
    const WRITE_SIZE: usize = 8;
    const RECOGNISES_DAMAGE: bool = true;

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

    fn wire(bus: impl Bus<Family = Self>, own: &OverCurrent) {
        own.watch(bus);
    }

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

    fn outlives_nmi(bus: impl Bus<Family = Self>) -> bool {
        flash::outlives_nmi(bus)
    }
}
