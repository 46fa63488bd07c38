//! Errors of constructors and of samples.

use core::fmt;

/// A configuration value outside its range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OutOfRange<Name = &'static str> {
    /// The parameter's name, as in the documentation of the configuration.
    pub parameter: Name,
    /// The value given, in the parameter's SI unit.
    pub value: f64,
    /// The values that are accepted.
    pub allowed: Allowed,
}

/// The range of a configuration value. Every range excludes NaN and the infinities.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// A whole, positive multiple of the step, to a relative 10⁻⁶.
    MultipleOf(f64),
}

impl Allowed {
    /// Relative deviation from a whole multiple that rounding explains.
    const WHOLE_TOLERANCE: f64 = 1e-6;

    /// True if the range contains the value.
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
                Self::MultipleOf(step) => {
                    let exact = value / step;
                    let whole = libm::round(exact);
                    whole >= 1.0 && libm::fabs(exact - whole) <= Self::WHOLE_TOLERANCE * whole
                }
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
            Err(OutOfRange::new(parameter, value, self))
        }
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Finite => write!(f, "any finite number"),
            Self::Above(low) => write!(f, "a number above {}", Plain(low)),
            Self::AtLeast(low) => write!(f, "a number of at least {}", Plain(low)),
            Self::Below(high) => write!(f, "a number below {}", Plain(high)),
            Self::AtMost(high) => write!(f, "a number of at most {}", Plain(high)),
            Self::Between(low, high) => {
                write!(f, "a number above {} and below {}", Plain(low), Plain(high))
            }
            Self::PositiveUpTo(high) => write!(f, "a number above 0 and at most {}", Plain(high)),
            Self::Within(only, high) if only.to_bits() == high.to_bits() => Plain(only).fmt(f),
            Self::Within(low, high) => write!(f, "a number from {} to {}", Plain(low), Plain(high)),
            Self::MultipleOf(step) => write!(f, "a whole multiple of {}", Plain(step)),
        }
    }
}

/// A number as people write it: of many digits only those that count.
struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Magnitudes from the first to below the second are written without an exponent.
        const WITHOUT: (f64, f64) = (1e-4, 1e7);
        let size = libm::fabs(self.0);
        if size > 0.0 && size.is_finite() && (size < WITHOUT.0 || size >= WITHOUT.1) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}

impl<Name> OutOfRange<Name> {
    /// A parameter's value and its range.
    #[must_use]
    pub const fn new(parameter: Name, value: f64, allowed: Allowed) -> Self {
        Self {
            parameter,
            value,
            allowed,
        }
    }

    /// The same with the name in another form.
    #[must_use]
    pub fn renamed<To>(self, rename: impl FnOnce(Name) -> To) -> OutOfRange<To> {
        OutOfRange::new(rename(self.parameter), self.value, self.allowed)
    }
}

impl<Name: fmt::Display> fmt::Display for OutOfRange<Name> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            ref parameter,
            value,
            allowed,
        } = *self;
        let shown = Plain(value);
        write!(
            f,
            "{parameter} = {shown} is not allowed: it must be {allowed}"
        )?;
        match allowed {
            Allowed::MultipleOf(step) if value > 0.0 && value.is_finite() => {
                let below = libm::floor(value / step).max(1.0);
                let (below, above) = (Nearest(below * step), Nearest((below + 1.0) * step));
                write!(f, ", such as {below} or {above}")
            }
            _ => Ok(()),
        }
    }
}

/// A multiple without the rounding error of its last digits.
struct Nearest(f64);

impl fmt::Display for Nearest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// A multiple is rounded to as many digits: relative to its size, below those of rounding.
        const DIGITS: f64 = 1e12;
        let mut scale = 1.0;
        while self.0 * scale < DIGITS {
            scale *= 10.0;
        }
        Plain(libm::round(self.0 * scale) / scale).fmt(f)
    }
}

impl<Name: fmt::Debug + fmt::Display> core::error::Error for OutOfRange<Name> {}

/// Why a sample was rejected. The state is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StepError {
    /// The position error is NaN or infinite: so was the setpoint's offset, or the measurement.
    #[error("the position error is not a finite number: check the setpoint")]
    ErrorNotFinite,
    /// Setpoint and position are further apart than the number format counts exactly.
    #[error(
        "the setpoint is too far from the position for the number format: check setpoint and encoder"
    )]
    TooFarApart,
    /// The increment since the last sample is NaN, larger than the number format counts exactly, or
    /// faster than `max_speed`.
    #[error(
        "the position has jumped further than the servo can move in a sample: check the encoder"
    )]
    CountJumped,
    /// The command that acted is NaN, infinite, or beyond the range of the number format.
    #[error("the command that acted is not a finite number")]
    CommandNotFinite,
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    use super::Allowed;

    #[test]
    fn a_value_between_multiples_is_shown_its_neighbours() {
        let every = Allowed::MultipleOf(0.001);
        for whole in [0.001, 0.1, 0.3, 7.0] {
            assert!(every.holds(whole), "{whole}");
        }
        for (other, neighbours) in [
            (0.1005, "0.1 or 0.101"),
            (0.0004, "0.001 or 0.002"),
            (0.29999, "0.299 or 0.3"),
        ] {
            let refused = every.check("hold", other).expect_err("no multiple");
            let refused = refused.to_string();
            assert!(refused.contains("a whole multiple of 0.001"), "{refused}");
            assert!(refused.ends_with(neighbours), "{refused}");
        }
        for never in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            assert!(!every.holds(never), "{never}");
        }
    }

    #[test]
    fn numbers_are_short_whatever_their_size() {
        for (value, shown) in [(1e300, "1e300"), (-2.5e-7, "-2.5e-7"), (1234.5, "1234.5")] {
            let refused = Allowed::Between(0.0, 1.0).check("x", value);
            let refused = refused.expect_err("out of range").to_string();
            let expected = std::format!("x = {shown} ");
            assert!(refused.starts_with(&expected), "{refused}");
        }
    }
}
