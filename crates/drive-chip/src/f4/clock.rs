//! 168 or 84 MHz from the board's oscillator (RM0090, 7; RM0368, 6).

use super::Stm32F4;
use super::registers::{flash, rcc};
use crate::family::{Bus, ClockTree, becomes};
use crate::frequencies::{Clocks, Kind};
use crate::registers::flash as cache;

/// The PLL's output before its division by two or four, Hz (RM0090, 7.3.2).
const VCO: u32 = 336_000_000;

/// Ticks until a new prescaler holds, at most (RM0090, 7.3.3). A read takes one at least.
const PRESCALER_TICKS: u32 = 16;

impl<const MEGAHERTZ: u32> Stm32F4<MEGAHERTZ> {
    const IS_FAST: bool = MEGAHERTZ > 84;

    /// Wait states of the flash at 2.7 V or more: one for each 30 MHz (RM0090, table 10; RM0368, table 6).
    const WAIT_STATES: u32 = MEGAHERTZ.div_ceil(30) - 1;
}

impl<const MEGAHERTZ: u32> ClockTree for Stm32F4<MEGAHERTZ> {
    /// The oscillator through the PLL. At 168 MHz the slow bus has a quarter of it and the fast one half; at 84 MHz half
    /// and all. Timers run at twice a bus that is slower than the processor (RM0090, 7.2).
    const CLOCKS: Clocks = Clocks {
        processor: 1_000_000 * MEGAHERTZ,
        low_bus: 42_000_000,
        low_timers: 84_000_000,
        high_timers: 1_000_000 * MEGAHERTZ,
    };
    /// It takes 1 to 2 MHz, and its jitter is least at 2 (RM0090, 7.3.2). Boards of the STM32F401 have 25 MHz.
    const PLL_INPUT: u32 = if Self::IS_FAST { 2_000_000 } else { 1_000_000 };
    const OSCILLATOR: [u32; 2] = [4_000_000, 26_000_000];

    fn reset_clock(bus: impl Bus<Family = Self>) {
        bus.modify(rcc::CFGR, rcc::CFGR_SW, 0);
        // It is ready: the switch takes a few ticks. The PLL is switched off after it.
        let _ = becomes(bus, rcc::CFGR, rcc::CFGR_SWS, rcc::CFGR_SWS_HSI);
        bus.modify(rcc::CFGR, rcc::CFGR_PRESCALERS, 0);
        bus.modify(rcc::CR, rcc::CR_PLLON | rcc::CR_CSSON, 0);
        bus.modify(rcc::CR, rcc::CR_HSEON, 0);
        bus.modify(rcc::CR, rcc::CR_HSEBYP, 0);
    }

    fn start_clock(bus: impl Bus<Family = Self>, frequency: u32, kind: Kind) -> Option<()> {
        // The bypass is set before the oscillator is switched on (RM0090, 7.3.1).
        if kind == Kind::Clock {
            bus.modify(rcc::CR, 0, rcc::CR_HSEBYP);
        }
        bus.modify(rcc::CR, 0, rcc::CR_HSEON);
        becomes(bus, rcc::CR, rcc::CR_HSERDY, rcc::CR_HSERDY)?;
        // An oscillator that fails later raises a non-maskable interrupt, and TIM1's break.
        bus.modify(rcc::CR, 0, rcc::CR_CSSON);
        // Q makes 48 MHz, which no driver here uses.
        let factors = (frequency / Self::PLL_INPUT)
            | (VCO / Self::PLL_INPUT) << rcc::PLLCFGR_N
            | if Self::IS_FAST {
                rcc::PLLCFGR_P_2
            } else {
                rcc::PLLCFGR_P_4
            }
            | rcc::PLLCFGR_HSE
            | 7 << rcc::PLLCFGR_Q;
        bus.modify(rcc::PLLCFGR, rcc::PLLCFGR_FACTORS, factors);
        bus.modify(rcc::CR, 0, rcc::CR_PLLON);
        becomes(bus, rcc::CR, rcc::CR_PLLRDY, rcc::CR_PLLRDY)?;
        // More wait states take effect before the processor is faster, and are read back (RM0090, 3.5.1).
        let access = Self::WAIT_STATES | cache::ACR_PRFTEN | cache::ACR_ICEN | cache::ACR_DCEN;
        bus.modify(flash::ACR, flash::ACR_LATENCY, access);
        becomes(bus, flash::ACR, flash::ACR_LATENCY, Self::WAIT_STATES)?;
        // A switch before the new prescalers hold would first drive the buses beyond their limits.
        let prescalers = match Self::IS_FAST {
            true => rcc::CFGR_PPRE1_4 | rcc::CFGR_PPRE2_2,
            false => rcc::CFGR_PPRE1_2,
        };
        bus.modify(rcc::CFGR, rcc::CFGR_PRESCALERS, prescalers);
        for _ in 0..PRESCALER_TICKS {
            let _ = bus.read(rcc::CFGR);
        }
        bus.modify(rcc::CFGR, rcc::CFGR_SW, rcc::CFGR_SW_PLL);
        becomes(bus, rcc::CFGR, rcc::CFGR_SWS, rcc::CFGR_SWS_PLL)
    }
}
