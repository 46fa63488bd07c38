use core::fmt;

use crate::error::OutOfRange;
use crate::parameters::Term;
use crate::stability::{CertificateError, EstimateError, SampledLoopError};

/// Why no Γ can be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum GainError {
    /// The reference leaves a servo of the parameter range at rest.
    AtRest,
    /// The loop around a servo of the parameter range leaves the range of numbers.
    Unstable,
}

impl fmt::Display for GainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AtRest => {
                "the reference does not move the servo, so no gamma follows from it: choose a reference that moves, \
                 or state gamma"
            }
            Self::Unstable => {
                "the loop is unstable for a servo of the parameter range, so no gamma follows from it: lower the \
                 gains, sample faster, or narrow the parameter range"
            }
        })
    }
}

impl core::error::Error for GainError {}

/// Why a part cannot be built from its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SettingsError {
    /// A value outside its range.
    Range(OutOfRange),
    /// None was given, and none can be chosen.
    NoGamma(GainError),
    /// The certificate fails.
    Certificate(CertificateError),
    /// The sampled loop of a servo in the parameter range is unstable.
    SampledLoop(SampledLoopError),
    /// The sampled correction is unstable for an estimate that the bounds allow.
    Estimate(EstimateError),
    /// A term is requested or declared that the set of unknowns does not have.
    NoSuchTerm {
        /// The term.
        term: Term,
    },
    /// The amplifier has a declared effect, but no stage in front of the identifier applies it to
    /// the command. See [`Amplifier`](crate::model::Amplifier).
    NoAmplifier {
        /// The name of the setting.
        setting: &'static str,
    },
    /// The controller has a reference filter, a feed-forward or a notch, and its type has none. See
    /// [`Shaped`](crate::control::Shaped).
    NotShaped {
        /// The name of the setting.
        setting: &'static str,
    },
    /// A setting that has no default and was not given.
    NotGiven {
        /// Its name.
        setting: &'static str,
    },
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::NoGamma(error) => error.fmt(f),
            Self::Certificate(error) => error.fmt(f),
            Self::SampledLoop(error) => error.fmt(f),
            Self::Estimate(error) => error.fmt(f),
            Self::NoSuchTerm { term } => write!(
                f,
                "this model has no term \"{}\": take a set of unknowns that has it, or leave the term out",
                term.name()
            ),
            Self::NoAmplifier { setting } => write!(
                f,
                "{setting} is declared, but for this identifier every command acts at once: leave it out, or put the \
                 amplifier in front of the identifier (not in fixed point)"
            ),
            Self::NotShaped { setting } => write!(
                f,
                "this controller has no {setting}: build it as Controller<_, _, Shaped<_>>, or leave {setting} out"
            ),
            Self::NotGiven { setting } => write!(f, "{setting} is required here"),
        }
    }
}

impl core::error::Error for SettingsError {}

/// Each error that is one of the settings.
macro_rules! from {
    ($($error:ty => $kind:ident),* $(,)?) => {
        $(impl From<$error> for SettingsError {
            fn from(error: $error) -> Self {
                Self::$kind(error)
            }
        })*
    };
}

from! {
    OutOfRange => Range,
    GainError => NoGamma,
    CertificateError => Certificate,
    SampledLoopError => SampledLoop,
    EstimateError => Estimate,
}
