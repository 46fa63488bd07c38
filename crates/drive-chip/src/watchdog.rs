//! The independent watchdog, which resets the chip unless it is fed (RM0090, 21).
//!
//! Its timeout is set once. A new one takes effect some ticks of its own oscillator after the write, and until then
//! either may hold.

use crate::bus::Register;
use crate::family::Bus;
use crate::registers::iwdg;

/// Its oscillator, Hz; 17 to 47 kHz by the data sheet.
const OSCILLATOR: u32 = 32_000;

/// The time without being fed after which it resets the chip, ms: by its oscillator 6.8 to 18.8.
pub const TIMEOUT: u32 = 10;

/// Ticks of the counter, a quarter of the oscillator's, in the timeout.
const RELOAD: u32 = TIMEOUT * (OSCILLATOR / 4) / 1000 - 1;

/// Reads of its status until a new timeout holds, at most five ticks of the oscillator.
const MAX_READS: u32 = 100_000;

/// The write that feeds it; without effect before it is started.
pub(crate) const FOOD: (Register, u32) = (iwdg::KR, iwdg::KEY_FEED);

/// The watchdog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Watchdog<B> {
    bus: B,
}

impl<B: Bus> Watchdog<B> {
    /// Not started.
    pub(crate) fn new(bus: B) -> Self {
        Self { bus }
    }

    /// Starts it. Only a reset stops it again.
    pub fn start(&self) {
        let bus = self.bus;
        bus.write(iwdg::KR, iwdg::KEY_START);
        bus.write(iwdg::KR, iwdg::KEY_ACCESS);
        bus.write(iwdg::PR, iwdg::PR_4);
        bus.write(iwdg::RLR, RELOAD);
        // Fed earlier, it would begin with the reset value of half a second.
        let _ = (0..MAX_READS).any(|_| bus.read(iwdg::SR) == 0);
        self.feed();
    }

    /// Restarts its timeout.
    #[inline]
    pub fn feed(&self) {
        feed(self.bus);
    }
}

/// Restarts the timeout of a watchdog that was started.
#[inline(always)]
pub(crate) fn feed(bus: impl Bus) {
    let (register, key) = FOOD;
    bus.write(register, key);
}
