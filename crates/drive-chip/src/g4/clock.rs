//! 170 MHz from the board's oscillator (RM0440, RCC).

use super::G4;
use super::registers::{flash, pwr, rcc};
use crate::family::{Bus, ClockTree, becomes};
use crate::frequencies::{Clocks, Kind};
use crate::registers::flash as cache;

/// The PLL's output before its division by two, Hz (RM0440, RCC).
const VCO: u32 = 340_000_000;

/// Wait states of the flash at 170 MHz with the boost (RM0440, FLASH).
const WAIT_STATES: u32 = 4;

/// Reads for the first microsecond after the switch: at 85 MHz, a tick each at least (RM0440, PWR).
const STEADY_READS: u32 = 100;

impl ClockTree for G4 {
    /// The oscillator through the PLL: 170 MHz for everything (RM0440, RCC).
    const CLOCKS: Clocks = Clocks {
        processor: 170_000_000,
        low_bus: 170_000_000,
        low_timers: 170_000_000,
        high_timers: 170_000_000,
    };
    /// It takes 2.66 to 16 MHz (RM0440, RCC).
    const PLL_INPUT: u32 = 4_000_000;
    const OSCILLATOR: [u32; 2] = [4_000_000, 48_000_000];

    fn reset_clock(bus: impl Bus<Family = Self>) {
        // Half of the clock on the way down too (RM0440, PWR).
        if bus.read(rcc::CFGR) & rcc::CFGR_SWS == rcc::CFGR_SWS_PLL {
            bus.modify(rcc::CFGR, rcc::CFGR_HPRE, rcc::CFGR_HPRE_2);
        }
        bus.modify(rcc::CFGR, rcc::CFGR_SW, rcc::CFGR_SW_HSI);
        // It is ready: the switch takes a few ticks. The PLL is switched off after it.
        let _ = becomes(bus, rcc::CFGR, rcc::CFGR_SWS, rcc::CFGR_SWS_HSI);
        bus.modify(rcc::CFGR, rcc::CFGR_PRESCALERS, 0);
        bus.modify(rcc::CR, rcc::CR_PLLON, 0);
        // An oscillator that is watched would be taken for one that has failed: a debugger that restarts the program leaves
        // it on.
        if bus.read(rcc::CR) & rcc::CR_CSSON == 0 {
            bus.modify(rcc::CR, rcc::CR_HSEON, 0);
            bus.modify(rcc::CR, rcc::CR_HSEBYP, 0);
        }
    }

    fn start_clock(bus: impl Bus<Family = Self>, frequency: u32, kind: Kind) -> Option<()> {
        // The bypass is set before the oscillator is switched on (RM0440, RCC).
        if kind == Kind::Clock {
            bus.modify(rcc::CR, 0, rcc::CR_HSEBYP);
        }
        bus.modify(rcc::CR, 0, rcc::CR_HSEON);
        becomes(bus, rcc::CR, rcc::CR_HSERDY, rcc::CR_HSERDY)?;
        let factors = rcc::PLLCFGR_HSE
            | (frequency / Self::PLL_INPUT - 1) << rcc::PLLCFGR_M
            | (VCO / Self::PLL_INPUT) << rcc::PLLCFGR_N
            | rcc::PLLCFGR_R_2
            | rcc::PLLCFGR_REN;
        bus.modify(rcc::PLLCFGR, rcc::PLLCFGR_FACTORS, factors);
        bus.modify(rcc::CR, 0, rcc::CR_PLLON);
        becomes(bus, rcc::CR, rcc::CR_PLLRDY, rcc::CR_PLLRDY)?;
        // Beyond 150 MHz the core's voltage is boosted, and the first microsecond takes half of the clock (RM0440, PWR).
        bus.modify(rcc::CFGR, rcc::CFGR_PRESCALERS, rcc::CFGR_HPRE_2);
        super::supply::power(bus);
        bus.modify(pwr::CR5, pwr::CR5_R1MODE, 0);
        // More wait states take effect before the processor is faster, and are read back (RM0440, FLASH).
        let access = WAIT_STATES | cache::ACR_PRFTEN | cache::ACR_ICEN | cache::ACR_DCEN;
        bus.modify(flash::ACR, flash::ACR_LATENCY, access);
        becomes(bus, flash::ACR, flash::ACR_LATENCY, WAIT_STATES)?;
        bus.modify(rcc::CFGR, rcc::CFGR_SW, rcc::CFGR_SW_PLL);
        becomes(bus, rcc::CFGR, rcc::CFGR_SWS, rcc::CFGR_SWS_PLL)?;
        for _ in 0..STEADY_READS {
            let _ = bus.read(rcc::CFGR);
        }
        bus.modify(rcc::CFGR, rcc::CFGR_HPRE, 0);
        // An oscillator that fails later raises a non-maskable interrupt, and TIM1's break. Only a reset ends this watch: it
        // begins when nothing is left that could fail.
        bus.modify(rcc::CR, 0, rcc::CR_CSSON);
        Some(())
    }
}
