use crate::constants::encode;
use crate::error::{Allowed, OutOfRange};
use crate::interval::Interval;

/// Where the true servo may lie: a ∈ [a_min, a_max] (1/s), b ∈ [b_min, b_max] (rad/s² per command
/// unit).
///
/// The range is that of the servo's parameters. Estimates may start and move outside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterRange {
    a: Interval,
    b: Interval,
}

encode! {
    [] ParameterRange as "ServoRange" { a, b }
}

impl ParameterRange {
    /// The parameter range.
    ///
    /// # Errors
    /// a_min must be at least 0 and b_min above 0.
    pub fn new(a: Interval, b: Interval) -> Result<Self, OutOfRange> {
        Allowed::AtLeast(0.0).check("a_min", a.min())?;
        Allowed::Above(0.0).check("b_min", b.min())?;
        Ok(Self { a, b })
    }

    /// The range of a, 1/s.
    #[must_use]
    pub fn a(&self) -> Interval {
        self.a
    }

    /// The range of b, rad/s² per command unit.
    #[must_use]
    pub fn b(&self) -> Interval {
        self.b
    }

    /// The smallest α = a + b k_d in the parameter range, 1/s.
    #[must_use]
    pub fn slowest_decay(&self, kd: f64) -> f64 {
        self.a.min() + self.b.min() * kd
    }
}
