//! Instructions counted by a timer: where one tick is one instruction, as in an emulator that
//! counts them. On the chip the same timer counts cycles.

use crate::host::{Text, print};

const RCC_APB1ENR: *mut u32 = 0x4002_3840 as *mut u32;
const TIM2: usize = 0x4000_0000;
const CR1: *mut u32 = TIM2 as *mut u32;
const EGR: *mut u32 = (TIM2 + 0x14) as *mut u32;
const CNT: *mut u32 = (TIM2 + 0x24) as *mut u32;
const PSC: *mut u32 = (TIM2 + 0x28) as *mut u32;
const ARR: *mut u32 = (TIM2 + 0x2c) as *mut u32;

/// TIM2, running freely.
#[derive(Debug)]
pub struct Counter(());

impl Counter {
    /// Starts the timer.
    #[must_use]
    pub fn start() -> Self {
        // SAFETY: registers of RCC and TIM2 (RM0090, 7.3.13 and 18.4), which nothing else here uses.
        unsafe {
            RCC_APB1ENR.write_volatile(RCC_APB1ENR.read_volatile() | 1);
            PSC.write_volatile(0);
            ARR.write_volatile(u32::MAX);
            EGR.write_volatile(1);
            CR1.write_volatile(1);
        }
        Self(())
    }

    /// Ticks so far.
    #[inline(always)]
    #[must_use]
    pub fn now(&self) -> u32 {
        ticks()
    }
}

/// Ticks of the timer, if it was started.
#[inline(always)]
#[must_use]
pub fn ticks() -> u32 {
    // SAFETY: a read of TIM2's counter has no effect.
    unsafe { CNT.read_volatile() }
}

/// Costs of several rounds.
#[derive(Debug, Default)]
pub struct Tally {
    rounds: u32,
    total: u32,
    max: u32,
}

impl Tally {
    /// One more round.
    pub fn add(&mut self, taken: u32) {
        self.rounds += 1;
        self.total = self.total.wrapping_add(taken);
        self.max = self.max.max(taken);
    }

    /// Takes the maximum of other rounds in, and not their mean.
    pub fn take_max(&mut self, other: &Self) {
        self.max = self.max.max(other.max);
    }

    /// The rounds so far.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// Their sum.
    #[must_use]
    pub fn total(&self) -> u32 {
        self.total
    }

    /// Prints a name, the mean, the maximum, and the size of a state.
    pub fn print(&self, name: &str, state_bytes: usize) {
        let mean = self.total / self.rounds.max(1);
        let [mean, max, bytes] = [mean, self.max, state_bytes as u32].map(Text::whole);
        print(&[name, mean.as_str(), max.as_str(), bytes.as_str()]);
    }
}
