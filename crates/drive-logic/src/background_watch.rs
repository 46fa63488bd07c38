//! The watch over the background, which must run now and then for the watchdog to be fed.

/// The longest pause of the background while the servo is driven, s. After it the watchdog resets the chip.
pub(crate) const DRIVEN_PATIENCE: f64 = 0.1;

/// The longest time without a turn of the background.
///
/// A count runs down in every sample. Only at its end are the background's turns compared with those before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BackgroundWatch {
    interval: u32,
    left: u32,
    turns: u32,
}

impl BackgroundWatch {
    /// Before the first sample.
    pub(crate) const fn new() -> Self {
        Self {
            interval: 1,
            left: 1,
            turns: 0,
        }
    }

    /// Lasts from half of these samples to all of them, from the next comparison on.
    pub(crate) fn set_patience(&mut self, samples: u32) {
        self.interval = (samples / 2).max(1);
    }

    /// Counts from now on.
    pub(crate) fn begin(&mut self, samples: u32, turns: u32) {
        self.set_patience(samples);
        (self.turns, self.left) = (turns, self.interval);
    }

    /// False if the background has not run for too long, a sample later.
    #[inline]
    pub(crate) fn lasts(&mut self, turns: impl FnOnce() -> u32) -> bool {
        self.left -= 1;
        self.left > 0 || self.has_run(turns())
    }

    #[cold]
    fn has_run(&mut self, turns: u32) -> bool {
        let has_run = turns != self.turns;
        self.turns = turns;
        // Without a turn, the next sample compares again.
        self.left = if has_run { self.interval } else { 1 };
        has_run
    }
}
