use identifier_core::error::OutOfRange;

/// Effects that a servo cannot have.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EffectError {
    /// A value outside its range.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// An effect that needs another value beside it.
    #[error("{effect} has no effect without {needs}: state both or neither")]
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
