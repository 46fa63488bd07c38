//! Errors of constructors and of samples.

use core::fmt;

/// A configuration value outside its range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutOfRange {
    /// The parameter's name, as in the documentation of the configuration.
    pub parameter: &'static str,
    /// The value given, in the parameter's SI unit.
    pub value: f64,
    /// What would have been accepted.
    pub allowed: Allowed,
}

/// The range of a configuration value. Every range excludes NaN and the infinities.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Allowed {
    /// Any finite number.
    Finite,
    /// Greater than the bound.
    Above(f64),
    /// The bound or greater.
    AtLeast(f64),
    /// Less than the bound.
    Below(f64),
    /// The bound or less.
    AtMost(f64),
    /// Greater than the first bound and less than the second.
    Between(f64, f64),
    /// From the first bound to the second, both included.
    Within(f64, f64),
    /// Greater than zero, and the bound or less.
    PositiveUpTo(f64),
}

impl Allowed {
    /// Whether the range holds the value.
    #[must_use]
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::Above(low) => value > low,
                Self::AtLeast(low) => value >= low,
                Self::Below(high) => value < high,
                Self::AtMost(high) => value <= high,
                Self::Between(low, high) => value > low && value < high,
                Self::Within(low, high) => value >= low && value <= high,
                Self::PositiveUpTo(high) => value > 0.0 && value <= high,
            }
    }

    /// The value, if the range holds it.
    ///
    /// # Errors
    /// [`OutOfRange`] with the parameter's name.
    pub fn check(self, parameter: &'static str, value: f64) -> Result<f64, OutOfRange> {
        if self.holds(value) {
            Ok(value)
        } else {
            Err(OutOfRange {
                parameter,
                value,
                allowed: self,
            })
        }
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Finite => write!(f, "any finite number"),
            Self::Above(low) => write!(f, "a number above {low}"),
            Self::AtLeast(low) => write!(f, "a number of at least {low}"),
            Self::Below(high) => write!(f, "a number below {high}"),
            Self::AtMost(high) => write!(f, "a number of at most {high}"),
            Self::Between(low, high) => write!(f, "a number above {low} and below {high}"),
            Self::PositiveUpTo(high) => write!(f, "a number above 0 and at most {high:?}"),
            Self::Within(low, high) => write!(f, "a number from {low:?} to {high:?}"),
        }
    }
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} = {} is not allowed: it must be {}",
            self.parameter, self.value, self.allowed
        )
    }
}

impl core::error::Error for OutOfRange {}

/// Why a sample was refused. The state is as it was before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StepError {
    /// The position error is NaN or infinite: so was the setpoint's offset, or the measurement.
    ErrorNotFinite,
    /// Setpoint and position are further apart than the number format counts exactly.
    TooFarApart,
    /// The increment since the last sample is NaN, larger than the number format counts exactly, or
    /// faster than `max_speed`.
    CountJumped,
    /// The command that acted is NaN, infinite, or beyond what the number format computes with.
    CommandNotFinite,
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ErrorNotFinite => "the position error is not a finite number: check the setpoint",
            Self::TooFarApart => {
                "the setpoint is further from the position than the number format counts exactly: \
                 check setpoint and encoder"
            }
            Self::CountJumped => {
                "the position has jumped further than the servo can move in a sample: check the encoder"
            }
            Self::CommandNotFinite => "the command that acted is not a finite number",
        })
    }
}

impl core::error::Error for StepError {}
