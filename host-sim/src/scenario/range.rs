//! The ranges of numbers.

use std::fmt;

use identifier_core::error::Allowed;
use serde_json::{Value, json};
use virtual_servo::Effects;

/// The range of a number.
#[derive(Debug, Clone, Copy)]
pub(super) enum Range {
    /// A fixed one.
    Fixed(Allowed),
    /// Above 0 and below half the sample rate, rad/s.
    BelowNyquist,
    /// Above 0 and at most half a radian per sample.
    HalfRadian,
    /// The duration of a run.
    Duration,
    /// The delay of a command.
    Delay,
    /// The size of a fault, by its kind.
    FaultSize,
    /// A whole number of control samples, or of pairs of them.
    Samples,
    EvenSamples,
}

impl Range {
    /// The part of the range that holds for any sample time; the core checks the rest.
    pub(super) fn fixed(self) -> Allowed {
        match self {
            Self::Fixed(allowed) => allowed,
            Self::Delay => Allowed::Within(0.0, Effects::MAX_DELAY),
            Self::FaultSize => Allowed::Finite,
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
            Self::Delay => {
                let (longest, max_samples) = (Effects::MAX_DELAY, Effects::MAX_DELAYED_SAMPLES);
                write!(
                    f,
                    "a number from 0 to {longest}, at most {max_samples} control samples"
                )
            }
            Self::FaultSize => {
                let most = Effects::LARGEST_ACCELERATION;
                write!(
                    f,
                    "a number: of encoder-jump, counts; of actuator-weak, a share from 0 to 1; of \
                     load-step, up to {most:e} rad/s² in either direction; of friction-rise, 0 to {most:e} rad/s²"
                )
            }
            Self::Samples => f.write_str("a whole number of control samples"),
            Self::EvenSamples => f.write_str("an even number of control samples"),
        }
    }
}
