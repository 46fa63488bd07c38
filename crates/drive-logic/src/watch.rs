//! Which samples are shown to the host.

/// Which samples are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Watch {
    /// Samples from one to the next; 0 for none.
    every: u16,
    left: u32,
}

impl Watch {
    pub(crate) const NONE: Self = Self::every(0);

    /// The next sample, and then every so many.
    pub(crate) const fn every(every: u16) -> Self {
        Self {
            every,
            left: if every == 0 { u32::MAX } else { 1 },
        }
    }

    /// Whether this sample is to be shown.
    #[inline]
    pub(crate) fn is_due(&mut self) -> bool {
        self.left -= 1;
        self.left == 0 && self.begin_anew()
    }

    #[cold]
    fn begin_anew(&mut self) -> bool {
        let is_due = self.every > 0;
        self.left = if is_due { self.every.into() } else { u32::MAX };
        is_due
    }
}
