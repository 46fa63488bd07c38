//! The timer for listening to the line. A stop in the middle of other bytes raises no interrupt of its own.

use crate::clock::Clocks;
use crate::family::Bus;
use crate::registers::systick;

/// How often the line is listened to, Hz: every 25 bytes.
const FREQUENCY: u32 = 4_000;

/// The longest time from the arrival of a byte until it is heard, s, in which samples are served first.
pub const PERIOD: f64 = 1.0 / FREQUENCY as f64;

/// SysTick, whose handler requests the serial line's interrupt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineTimer<B> {
    bus: B,
    ticks: u32,
}

impl<B: Bus> LineTimer<B> {
    /// Not started.
    pub(crate) fn new(bus: B, clocks: &Clocks) -> Self {
        Self {
            bus,
            ticks: clocks.processor / FREQUENCY,
        }
    }

    /// Starts it.
    pub fn start(&self) {
        let Self { bus, ticks } = *self;
        bus.write(systick::RVR, ticks.saturating_sub(1));
        bus.write(systick::CVR, 0);
        bus.write(
            systick::CSR,
            systick::CSR_ENABLE | systick::CSR_TICKINT | systick::CSR_PROCESSOR,
        );
    }
}
