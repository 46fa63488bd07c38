//! Instructions, where a timer ticks at each: TIM2 of an emulated STM32F405. Without the feature `count`
//! nothing is counted.

use core::fmt::Write;
use core::hint::black_box;

use cortex_m_semihosting::hio;

const RCC_APB1ENR: *mut u32 = 0x4002_3840 as *mut u32;
const CR1: *mut u32 = 0x4000_0000 as *mut u32;
const COUNTER: *mut u32 = 0x4000_0024 as *mut u32;

/// Calls that are not counted: the servo starts moving.
const STARTING: u32 = 500;

/// The timer, with what was counted so far.
pub(crate) struct Count {
    calls: u32,
    total: u32,
}

impl Count {
    /// Starts the timer.
    pub(crate) fn start() -> Self {
        if cfg!(feature = "count") {
            // SAFETY: registers of RCC and TIM2 (RM0090, 7.3.13 and 18.4), which nothing else uses.
            unsafe {
                RCC_APB1ENR.write_volatile(RCC_APB1ENR.read_volatile() | 1);
                CR1.write_volatile(1);
            }
        }
        Self { calls: 0, total: 0 }
    }

    /// Does some work and adds what it took, less what counting takes.
    #[inline(always)]
    pub(crate) fn count<T>(&mut self, work: impl FnOnce() -> T) -> T {
        if cfg!(not(feature = "count")) {
            return work();
        }
        let empty = {
            let before = now();
            now().wrapping_sub(before)
        };
        let before = now();
        let result = work();
        let taken = now().wrapping_sub(before).wrapping_sub(empty);
        self.calls += 1;
        if self.calls > STARTING {
            self.total = self.total.wrapping_add(taken);
        }
        black_box(result)
    }

    /// Prints the mean over all calls that were counted.
    pub(crate) fn print(&self) {
        if cfg!(feature = "count")
            && let Ok(mut out) = hio::hstdout()
        {
            let counted = self.calls.saturating_sub(STARTING).max(1);
            let _ = writeln!(out, "{}", self.total / counted);
        }
    }
}

#[inline(always)]
fn now() -> u32 {
    // SAFETY: a read of TIM2's counter has no effect.
    unsafe { COUNTER.read_volatile() }
}
