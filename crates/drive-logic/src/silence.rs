//! For how long the host has been silent.

use identifier_core::units::Units;

use crate::time::samples;

/// The watch over a host that must be heard now and then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Silence {
    most: u32,
    left: u32,
}

impl Silence {
    /// It may last so long, s; 0 for ever.
    pub(crate) fn of(time: f64, units: &Units) -> Self {
        let most = if time > 0.0 {
            samples(time, units)
        } else {
            u32::MAX
        };
        Self { most, left: most }
    }

    /// The host was heard.
    pub(crate) fn end(&mut self) {
        self.left = self.most;
    }

    /// Whether it has lasted too long, a sample later.
    #[inline]
    pub(crate) fn is_too_long(&mut self) -> bool {
        if self.most == u32::MAX {
            return false;
        }
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }
}
