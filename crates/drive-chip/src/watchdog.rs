//! The independent watchdog, which resets the chip unless it is fed (RM0090, 21).
//!
//! It has one patience for ever: a new one holds only some ticks of its own oscillator after it was
//! written, and until then nobody knows which of them does.

use crate::bus::Bus;
use crate::registers::iwdg;

/// Its oscillator, Hz; from 17 to 47 kHz by the data sheet.
const OSCILLATOR: u32 = 32_000;

/// The time without food after which it resets the chip, ms: by its oscillator 6.8 to 18.8.
pub const PATIENCE: u32 = 10;

/// Ticks of the counter, a quarter of the oscillator's, in its patience.
const RELOAD: u32 = PATIENCE * (OSCILLATOR / 4) / 1000 - 1;

/// Turns of a loop that a new patience takes to hold, five ticks of the oscillator at most.
const TURNS: u32 = 100_000;

/// The watchdog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Watchdog<B> {
    bus: B,
}

impl<B: Bus> Watchdog<B> {
    /// Asleep.
    pub(crate) fn new(bus: B) -> Self {
        Self { bus }
    }

    /// Wakes it. Nothing but a reset puts it to sleep again.
    pub fn start(&self) {
        let bus = self.bus;
        bus.write(iwdg::KR, iwdg::KEY_START);
        bus.write(iwdg::KR, iwdg::KEY_ACCESS);
        bus.write(iwdg::PR, iwdg::PR_4);
        bus.write(iwdg::RLR, RELOAD);
        // Fed before, it would begin with half a second.
        let _ = (0..TURNS).any(|_| bus.read(iwdg::SR) == 0);
        self.feed();
    }

    /// Begins its patience anew.
    #[inline]
    pub fn feed(&self) {
        feed(self.bus);
    }
}

/// Feeds it; without effect while it is asleep.
#[inline(always)]
pub(crate) fn feed(bus: impl Bus) {
    bus.write(iwdg::KR, iwdg::KEY_FEED);
}
