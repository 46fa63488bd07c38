//! Whether the background still goes round.

use crate::channel::InterruptEnd;

/// How long the background may not be seen to go round.
///
/// A count runs down in every sample; only when it has run out is the background looked at, and then it
/// has gone round since, or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Patience {
    most: u32,
    left: u32,
    times: u32,
}

impl Patience {
    /// It lasts from half of so many samples to all of them.
    pub(crate) fn of(samples: u32) -> Self {
        let mut patience = Self {
            most: 1,
            left: 1,
            times: 0,
        };
        patience.set(samples);
        patience.left = patience.most;
        patience
    }

    /// From the next time on that it is renewed.
    pub(crate) fn set(&mut self, samples: u32) {
        self.most = (samples / 2).max(1);
    }

    pub(crate) fn begin(&mut self, channel: &InterruptEnd<'_>) {
        self.times = channel.times_alive();
        self.left = self.most;
    }

    #[inline]
    pub(crate) fn lasts(&mut self, channel: &InterruptEnd<'_>) -> bool {
        self.left -= 1;
        self.left > 0 || self.is_renewed(channel)
    }

    #[cold]
    fn is_renewed(&mut self, channel: &InterruptEnd<'_>) -> bool {
        let is_alive = channel.times_alive() != self.times;
        if is_alive {
            self.begin(channel);
        } else {
            // Until it is seen again.
            self.left = 1;
        }
        is_alive
    }
}
