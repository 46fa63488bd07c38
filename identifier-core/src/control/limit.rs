use crate::error::{Allowed, OutOfRange};

/// The range of commands that the amplifier accepts. Zero is always inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandLimit {
    low: f64,
    high: f64,
}

impl CommandLimit {
    /// No limit. A sample whose command is beyond the range of the number format is refused.
    pub const NONE: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// |u| ≤ `limit`, command units.
    ///
    /// # Errors
    /// `limit` must be positive and finite; for no limit take [`CommandLimit::NONE`].
    pub fn symmetric(limit: f64) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("limit", limit)?;
        Ok(Self {
            low: -limit,
            high: limit,
        })
    }

    /// `low` ≤ u ≤ `high`, command units.
    ///
    /// # Errors
    /// `limit_low` must be negative, `limit_high` positive, both finite.
    pub fn asymmetric(low: f64, high: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            low: Allowed::Below(0.0).check("limit_low", low)?,
            high: Allowed::Above(0.0).check("limit_high", high)?,
        })
    }

    /// Lowest and highest command, command units, both infinite for none.
    ///
    /// # Errors
    /// As [`CommandLimit::asymmetric`].
    pub fn from_range([low, high]: [f64; 2]) -> Result<Self, OutOfRange> {
        if low == f64::NEG_INFINITY && high == f64::INFINITY {
            Ok(Self::NONE)
        } else {
            Self::asymmetric(low, high)
        }
    }

    /// The lowest command, command units.
    #[must_use]
    pub fn low(&self) -> f64 {
        self.low
    }

    /// The highest command, command units.
    #[must_use]
    pub fn high(&self) -> f64 {
        self.high
    }
}
