//! Closed intervals of configuration values.

use crate::constants::encode;
use crate::error::{Allowed, OutOfRange};

/// A closed interval of finite numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    min: f64,
    max: f64,
}

encode! {
    [] Interval as "Interval" { min, max }
}

impl Interval {
    /// The interval from `min` to `max`; `parameter` names it in the error.
    ///
    /// # Errors
    /// Both ends must be finite and `max` at least `min`.
    pub fn new(parameter: &'static str, min: f64, max: f64) -> Result<Self, OutOfRange> {
        Allowed::Finite.check(parameter, min)?;
        Allowed::AtLeast(min).check(parameter, max)?;
        Ok(Self { min, max })
    }

    /// The lower end.
    #[must_use]
    pub fn min(&self) -> f64 {
        self.min
    }

    /// The upper end.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.max
    }

    /// The interval in a unit of which `scale` make one of this; `scale` is positive.
    #[must_use]
    pub fn scaled(&self, scale: f64) -> Self {
        Self {
            min: self.min * scale,
            max: self.max * scale,
        }
    }

    /// True if the interval contains a value.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        value >= self.min && value <= self.max
    }
}
