//! Whether a servo that is to stand has come to rest.

use identifier_core::units::Units;

use crate::time::samples;

/// Counts within which the servo is at rest, and for how long, s.
const AT_REST: u32 = 4;
const REST_TIME: f64 = 0.02;

/// How a servo comes to rest, or does not within its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    most: u32,
    needed: u32,
    /// Where it has stayed for how many samples, and how many are left.
    at: i32,
    still: u32,
    left: u32,
}

impl Rest {
    /// It may take so long, s.
    pub(crate) fn within(time: f64, units: &Units) -> Self {
        let most = samples(time, units);
        Self {
            most,
            needed: samples(REST_TIME, units),
            at: 0,
            still: 0,
            left: most,
        }
    }

    /// From a count on.
    pub(crate) fn begin(&mut self, count: i32) {
        (self.at, self.still, self.left) = (count, 0, self.most);
    }

    /// Whether it rests after a sample at a count, or its time is over.
    pub(crate) fn is_over(&mut self, count: i32) -> bool {
        if count.wrapping_sub(self.at).unsigned_abs() > AT_REST {
            (self.at, self.still) = (count, 0);
        } else {
            self.still = self.still.saturating_add(1);
        }
        self.left = self.left.saturating_sub(1);
        self.still >= self.needed || self.left == 0
    }
}
