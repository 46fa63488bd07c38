//! The chip's clocks: 168 MHz from the board's crystal.
//!
//! The HAL's own set-up searches for the PLL's factors and panics where there are none, which a
//! release does not link with. So the HAL is left in its state after reset, and what depends on
//! clocks takes them from here.

use drive_link::Fault;
use stm32f4xx_hal::pac::{FLASH, RCC};

use crate::board;

/// What the clocks are, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// USART2 and its neighbours.
    pub low_bus: u32,
    /// Timers of the slow bus, TIM2 to TIM7.
    pub low_timers: u32,
    /// Timers of the fast bus, TIM1 and TIM8.
    pub high_timers: u32,
}

impl Clocks {
    /// After reset: the internal oscillator of 16 MHz for everything.
    const RESET: Self = Self {
        low_bus: 16_000_000,
        low_timers: 16_000_000,
        high_timers: 16_000_000,
    };

    /// The crystal through the PLL: 168 MHz, the slow bus a quarter of it, the fast one half.
    const FULL: Self = Self {
        low_bus: 42_000_000,
        low_timers: 84_000_000,
        high_timers: 168_000_000,
    };
}

/// The PLL's output before its division by two, Hz (RM0090, 7.3.2).
const VCO: u32 = 336_000_000;

/// The PLL's input, Hz: 1 to 2 MHz, at which its jitter is least.
const VCO_INPUT: u32 = 2_000_000;

const _: () = assert!(
    board::CRYSTAL.is_multiple_of(VCO_INPUT),
    "the board's crystal must be a multiple of 2 MHz"
);

/// Turns of a loop that a crystal or a PLL has to become ready, some 30 ms at 16 MHz.
const PATIENCE: u32 = 100_000;

/// Sets the clocks; where the crystal or the PLL does not become ready, they stay as after reset and
/// the fault says so.
pub fn start(rcc: &RCC, flash: &FLASH) -> (Clocks, Result<(), Fault>) {
    if cfg!(feature = "emulator") {
        // SAFETY: an emulated RCC is plain storage: nothing but this raises its ready bits.
        rcc.cr()
            .modify(|read, write| unsafe { write.bits(read.bits() | 1 << 17 | 1 << 25) });
    }
    rcc.cr().modify(|_, write| write.hseon().set_bit());
    if !becomes(|| rcc.cr().read().hserdy().bit_is_set()) {
        return (Clocks::RESET, Err(Fault::ClockNotStable));
    }
    // A crystal that fails later raises a non-maskable interrupt, and TIM1's break.
    rcc.cr().modify(|_, write| write.csson().set_bit());
    // SAFETY: M, N, P (00 is division by 2) and Q (48 MHz) are in range: RM0090, 7.3.2.
    rcc.pllcfgr().write(|write| unsafe {
        let write = write.pllm().bits((board::CRYSTAL / VCO_INPUT) as u8);
        let write = write.plln().bits((VCO / VCO_INPUT) as u16);
        write.pllp().div2().pllsrc().hse().pllq().bits(7)
    });
    rcc.cr().modify(|_, write| write.pllon().set_bit());
    if !becomes(|| rcc.cr().read().pllrdy().bit_is_set()) {
        return (Clocks::RESET, Err(Fault::ClockNotStable));
    }
    // Five wait states at 168 MHz and 2.7 V or more (RM0090, table 10).
    flash.acr().modify(|_, write| {
        let write = write.latency().ws5().prften().set_bit();
        write.icen().set_bit().dcen().set_bit()
    });
    rcc.cfgr()
        .modify(|_, write| write.ppre1().div4().ppre2().div2().sw().pll());
    (Clocks::FULL, Ok(()))
}

fn becomes(ready: impl Fn() -> bool) -> bool {
    (0..PATIENCE).any(|_| ready())
}
