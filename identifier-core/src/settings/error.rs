use thiserror::Error;

use crate::error::OutOfRange;
use crate::parameters::Term;
use crate::stability::{CertificateError, EstimateError, SampledLoopError};

/// Why no Γ can be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum GainError {
    /// The reference leaves a servo of the parameter range at rest.
    #[error(
        "the reference does not move the servo, so no gamma follows from it: choose a reference that moves, or state \
         gamma"
    )]
    AtRest,
    /// The loop around a servo of the parameter range leaves the range of numbers.
    #[error(
        "the loop is unstable for a servo of the parameter range, so no gamma follows from it: lower the gains, \
         sample faster, or narrow the parameter range"
    )]
    Unstable,
}

/// Why a part cannot be built from its settings.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SettingsError {
    /// A value outside its range.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// None was given, and none can be chosen.
    #[error(transparent)]
    NoGamma(#[from] GainError),
    /// The certificate fails.
    #[error(transparent)]
    Certificate(#[from] CertificateError),
    /// The sampled loop of a servo in the parameter range is unstable.
    #[error(transparent)]
    SampledLoop(#[from] SampledLoopError),
    /// The sampled correction is unstable for an estimate that the bounds allow.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// A term is requested or declared that the set of unknowns does not have.
    #[error(
        "this model has no term \"{}\": take a set of unknowns that has it, or leave the term out",
        term.name()
    )]
    NoSuchTerm {
        /// The term.
        term: Term,
    },
    /// The amplifier has a declared effect, but no stage in front of the identifier applies it to
    /// the command. See [`Amplifier`](crate::model::Amplifier).
    #[error(
        "{setting} is declared, but for this identifier every command acts at once: leave it out, or put the amplifier \
         in front of the identifier (not in fixed point)"
    )]
    NoAmplifier {
        /// The name of the setting.
        setting: &'static str,
    },
    /// The controller has a reference filter, a feed-forward or a notch, and its type has none. See
    /// [`Shaped`](crate::control::Shaped).
    #[error(
        "this controller has no {setting}: build it as Controller<_, _, Shaped<_>>, or leave {setting} out"
    )]
    NotShaped {
        /// The name of the setting.
        setting: &'static str,
    },
    /// A setting that has no default and was not given.
    #[error("{setting} is required here")]
    NotGiven {
        /// Its name.
        setting: &'static str,
    },
}
