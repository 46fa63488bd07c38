//! The unknowns of a drive that has terms.

use identifier_core::identifier::{AngledInputs, IdentifiableSet};
use identifier_core::number::Number;
use identifier_core::parameters::{Unknown, UnknownSet};

use super::MAX_DELAYED;

/// Their number.
pub(super) const UNKNOWNS: usize = Unknown::COUNT;

/// The four parameters and the sizes of all terms. A term enters if the settings demand it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WithTerms;

impl UnknownSet<UNKNOWNS> for WithTerms {
    const UNKNOWNS: [Unknown; UNKNOWNS] = Unknown::ALL;
}

impl IdentifiableSet<UNKNOWNS> for WithTerms {
    type Lower<N: Number> = [N; UNKNOWNS * (UNKNOWNS - 1) / 2];
    type Inputs<N: Number> = AngledInputs<N, MAX_DELAYED>;
}
