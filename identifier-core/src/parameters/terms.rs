use super::Term;
use crate::constants::encode;

/// Some of the terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Terms(u8);

encode! {
    [] Terms as "Terms" { 0 }
}

const _: () = assert!(Term::ALL.len() <= u8::BITS as usize, "a bit each");

impl Terms {
    /// None of them.
    pub const NONE: Self = Self(0);

    /// These and a term.
    #[must_use]
    pub const fn with(self, term: Term) -> Self {
        Self(self.0 | term.bit())
    }

    /// True if a term is one of them.
    #[must_use]
    pub const fn has(self, term: Term) -> bool {
        self.0 & term.bit() != 0
    }

    /// True if there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those in one or the other.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
