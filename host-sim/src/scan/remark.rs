//! The findings of a scan.

use std::fmt;

use serde::{Serialize, Serializer};

/// A finding about a log, one sentence with the key that mends it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Remark {
    /// Its kind.
    #[serde(serialize_with = "by_name")]
    pub kind: RemarkKind,
    /// The sentence, without an end.
    pub text: String,
    /// True if nothing that is identified on such a log can be relied on.
    pub refuses: bool,
}

/// The kinds of findings about a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RemarkKind {
    /// Too few samples.
    TooShort,
    /// The position shows its noise alone.
    NoiseAlone,
    /// Another unit of the position, or another encoder.
    PositionUnit,
    /// Another number of counts per revolution.
    CountsPerRev,
    /// The reference is in another unit or direction than the position.
    ReferenceUnit,
    /// Command or position has the wrong sign.
    Reversed,
    /// A column holds another quantity than stated.
    WrongColumn,
    /// The command does not act on the motion.
    NoEffect,
    /// The motion has one direction.
    OneDirection,
}

impl RemarkKind {
    /// True if it is concluded from how the motion goes with its command.
    pub(crate) const fn is_inferred(self) -> bool {
        matches!(self, Self::Reversed | Self::WrongColumn | Self::NoEffect)
    }

    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::TooShort => "too-short",
            Self::NoiseAlone => "noise-alone",
            Self::PositionUnit => "position-unit",
            Self::CountsPerRev => "counts-per-rev",
            Self::ReferenceUnit => "reference-unit",
            Self::Reversed => "reversed",
            Self::WrongColumn => "wrong-column",
            Self::NoEffect => "no-effect",
            Self::OneDirection => "one-direction",
        }
    }
}

impl Remark {
    /// A finding after which nothing can be relied on.
    pub(super) fn refusing(kind: RemarkKind, text: impl Into<String>) -> Self {
        Self {
            kind,
            text: text.into(),
            refuses: true,
        }
    }

    /// A finding that a user should know.
    pub(super) fn noting(kind: RemarkKind, text: impl Into<String>) -> Self {
        Self {
            refuses: false,
            ..Self::refusing(kind, text)
        }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn by_name<S: Serializer>(kind: &RemarkKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kind.name())
}
