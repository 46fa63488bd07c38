//! The ranges of numbers.

use std::fmt;

use identifier_core::error::Allowed;
use serde_json::{Value, json};

/// The range of a number.
#[derive(Debug, Clone, Copy)]
pub enum Range {
    /// A fixed one.
    Fixed(Allowed),
    /// Above 0 and below half the sample rate, rad/s.
    BelowNyquist,
    /// Above 0 and at most half a radian per sample.
    HalfRadian,
    /// The duration of a run.
    Duration,
    /// A fixed one whose words say more.
    Described(Allowed, fn() -> String),
    /// A whole number of control samples, or of pairs of them.
    Samples,
    /// An even one.
    EvenSamples,
}

impl Range {
    /// The part of the range that holds for any sample time; the core checks the rest.
    pub(super) fn fixed(self) -> Allowed {
        match self {
            Self::Fixed(allowed) | Self::Described(allowed, _) => allowed,
            _ => Allowed::Above(0.0),
        }
    }

    pub(super) fn schema(self) -> Value {
        let mut number = json!({ "type": "number" });
        let (low, high) = match self.fixed() {
            Allowed::Above(low) => (Some(("exclusiveMinimum", low)), None),
            Allowed::AtLeast(low) => (Some(("minimum", low)), None),
            Allowed::Within(low, high) => (Some(("minimum", low)), Some(("maximum", high))),
            Allowed::PositiveUpTo(high) => {
                (Some(("exclusiveMinimum", 0.0)), Some(("maximum", high)))
            }
            _ => (None, None),
        };
        for (name, end) in [low, high].into_iter().flatten() {
            number[name] = json!(end);
        }
        number
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(allowed) => allowed.fmt(f),
            Self::BelowNyquist => f.write_str("a number above 0 and below pi/sample_time"),
            Self::HalfRadian => f.write_str("a number above 0 and at most 0.5/sample_time"),
            Self::Duration => f.write_str("a time of 1 to 1e10 control samples"),
            Self::Described(_, words) => f.write_str(&words()),
            Self::Samples => f.write_str("a whole number of control samples"),
            Self::EvenSamples => f.write_str("an even number of control samples"),
        }
    }
}
