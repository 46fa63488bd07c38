use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::number::Number;

/// A relay: ± a level by the sign of the error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relay<N> {
    level: N,
}

impl<N: Number> Relay<N> {
    /// A relay of a level, command units.
    ///
    /// # Errors
    /// `relay` must be above zero.
    pub fn new(level: f64) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("relay", level)?;
        let level = N::from_f64(level);
        Ok(Self { level })
    }

    /// The command for an error q_d − q.
    #[inline]
    pub fn command(&self, error: N) -> N {
        if error >= N::ZERO {
            self.level
        } else {
            -self.level
        }
    }
}
