//! The chip's clocks: 168 MHz from the board's oscillator.

use drive_link::Fault;

use crate::board::{Kind, Oscillator};
use crate::bus::{Bus, Register};
use crate::registers::{flash, rcc};

/// Clock frequencies, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// The processor.
    pub processor: u32,
    /// USART2 and its neighbours.
    pub low_bus: u32,
    /// Timers of the slow bus, TIM2 to TIM7.
    pub low_timers: u32,
    /// Timers of the fast bus, TIM1 and TIM8.
    pub high_timers: u32,
}

impl Clocks {
    /// After reset: the internal oscillator of 16 MHz for everything.
    pub const RESET: Self = Self {
        processor: 16_000_000,
        low_bus: 16_000_000,
        low_timers: 16_000_000,
        high_timers: 16_000_000,
    };

    /// The oscillator through the PLL: 168 MHz, the slow bus a quarter of it, the fast one half;
    /// timers run at twice their bus (RM0090, 7.2).
    pub const FULL: Self = Self {
        processor: 168_000_000,
        low_bus: 42_000_000,
        low_timers: 84_000_000,
        high_timers: 168_000_000,
    };
}

/// The PLL's output before its division by two, Hz (RM0090, 7.3.2).
const VCO: u32 = 336_000_000;

/// Wait states of the flash at 168 MHz and 2.7 V or more (RM0090, table 10).
const WAIT_STATES: u32 = 5;

/// Ticks until a new prescaler holds, at most (RM0090, 7.3.3). A read takes one at least.
const PRESCALER_TICKS: u32 = 16;

/// Reads until a crystal, a PLL or a switch must be ready, some 30 ms at 16 MHz.
const MAX_READS: u32 = 100_000;

/// Sets the clocks. Where the oscillator or the PLL does not become ready they stay those after reset, and
/// the result is the fault.
pub fn start(bus: impl Bus, oscillator: Oscillator) -> (Clocks, Result<(), Fault>) {
    // A debugger restarts a program with the clocks of the previous run.
    to_reset(bus);
    if to_full(bus, oscillator).is_some() {
        (Clocks::FULL, Ok(()))
    } else {
        to_reset(bus);
        (Clocks::RESET, Err(Fault::ClockNotStable))
    }
}

fn to_full(bus: impl Bus, oscillator: Oscillator) -> Option<()> {
    // The bypass is set before the oscillator is switched on (RM0090, 7.3.1).
    if oscillator.kind == Kind::Clock {
        bus.modify(rcc::CR, 0, rcc::CR_HSEBYP);
    }
    bus.modify(rcc::CR, 0, rcc::CR_HSEON);
    becomes(bus, rcc::CR, rcc::CR_HSERDY, rcc::CR_HSERDY)?;
    // An oscillator that fails later raises a non-maskable interrupt, and TIM1's break.
    bus.modify(rcc::CR, 0, rcc::CR_CSSON);
    // Q makes 48 MHz, which no driver here uses.
    let factors = (oscillator.frequency / Oscillator::PLL_INPUT)
        | (VCO / Oscillator::PLL_INPUT) << rcc::PLLCFGR_N
        | rcc::PLLCFGR_P_2
        | rcc::PLLCFGR_HSE
        | 7 << rcc::PLLCFGR_Q;
    bus.modify(rcc::PLLCFGR, rcc::PLLCFGR_FACTORS, factors);
    bus.modify(rcc::CR, 0, rcc::CR_PLLON);
    becomes(bus, rcc::CR, rcc::CR_PLLRDY, rcc::CR_PLLRDY)?;
    // More wait states take effect before the processor is faster, and are read back (RM0090, 3.5.1).
    let access = WAIT_STATES | flash::ACR_PRFTEN | flash::ACR_ICEN | flash::ACR_DCEN;
    bus.modify(flash::ACR, flash::ACR_LATENCY, access);
    becomes(bus, flash::ACR, flash::ACR_LATENCY, WAIT_STATES)?;
    // A switch before the new prescalers hold would first drive the buses beyond their limits.
    let prescalers = rcc::CFGR_PPRE1_4 | rcc::CFGR_PPRE2_2;
    bus.modify(rcc::CFGR, rcc::CFGR_PRESCALERS, prescalers);
    for _ in 0..PRESCALER_TICKS {
        let _ = bus.read(rcc::CFGR);
    }
    bus.modify(rcc::CFGR, rcc::CFGR_SW, rcc::CFGR_SW_PLL);
    becomes(bus, rcc::CFGR, rcc::CFGR_SWS, rcc::CFGR_SWS_PLL)
}

/// Everything from the internal oscillator, which is on after reset and stays so.
fn to_reset(bus: impl Bus) {
    bus.modify(rcc::CFGR, rcc::CFGR_SW, 0);
    // It is ready: the switch takes a few ticks. The PLL is switched off after it.
    let _ = becomes(bus, rcc::CFGR, rcc::CFGR_SWS, rcc::CFGR_SWS_HSI);
    bus.modify(rcc::CFGR, rcc::CFGR_PRESCALERS, 0);
    bus.modify(rcc::CR, rcc::CR_PLLON | rcc::CR_CSSON, 0);
    bus.modify(rcc::CR, rcc::CR_HSEON, 0);
    bus.modify(rcc::CR, rcc::CR_HSEBYP, 0);
}

/// Waits until some bits of a register are as wanted.
fn becomes(bus: impl Bus, register: Register, bits: u32, wanted: u32) -> Option<()> {
    (0..MAX_READS)
        .any(|_| bus.read(register) & bits == wanted)
        .then_some(())
}
