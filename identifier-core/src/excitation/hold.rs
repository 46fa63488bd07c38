use crate::error::{Allowed, OutOfRange};

/// Counts the control samples of a hold, in which a reference is constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hold {
    left: u32,
}

impl Hold {
    /// Ends at the next sample.
    pub const EXPIRED: Self = Self { left: 0 };

    /// The steps (of `step` seconds) in a hold time, s.
    ///
    /// # Errors
    /// The time must be a whole, positive number of steps.
    pub fn steps(parameter: &'static str, time: f64, step: f64) -> Result<u32, OutOfRange> {
        let longest = f64::from(u32::MAX) * step;
        Allowed::MultipleOf(step).check(parameter, time)?;
        Allowed::AtMost(longest).check(parameter, time)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive and at most u32::MAX by the checks above"
        )]
        Ok(libm::round(time / step) as u32)
    }

    /// True once every `samples` samples, first at the first.
    #[inline]
    pub fn expires(&mut self, samples: u32) -> bool {
        if self.left == 0 {
            self.left = samples - 1;
            true
        } else {
            self.left -= 1;
            false
        }
    }
}
