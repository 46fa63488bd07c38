use core::fmt;

use identifier_core::error::OutOfRange;

/// Effects that a servo cannot have.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum EffectError {
    /// A value outside its range.
    Range(OutOfRange),
    /// An effect that needs another value beside it.
    Needs {
        /// The effect that is given.
        effect: &'static str,
        /// The effect that it needs.
        needs: &'static str,
    },
}

impl EffectError {
    /// The name of the value that is wrong.
    #[must_use]
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::Range(error) => error.parameter,
            Self::Needs { effect, .. } => effect,
        }
    }
}

impl From<OutOfRange> for EffectError {
    fn from(error: OutOfRange) -> Self {
        Self::Range(error)
    }
}

impl fmt::Display for EffectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::Needs { effect, needs } => {
                write!(
                    f,
                    "{effect} has no effect without {needs}: state both or neither"
                )
            }
        }
    }
}

impl core::error::Error for EffectError {}
