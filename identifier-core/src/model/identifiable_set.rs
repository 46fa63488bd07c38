use super::known_inputs::{AngledInputs, DelayedInputs, KnownInputs};
use crate::linalg::Lower;
use crate::number::Number;
use crate::parameters::sets::AB_COULOMB_DELAY_LOAD;
use crate::parameters::{AbLoad, AllUnknowns, Unknown, UnknownSet, Unknowns};

/// A set of unknowns with the memory for their identification, as types. So a model without a term keeps nothing for
/// it.
///
/// A firmware may have a set of its own:
///
/// ```
/// use identifier_core::identifier::{DelayedInputs, IdentifiableSet};
/// use identifier_core::number::Number;
/// use identifier_core::parameters::{Unknown, UnknownSet};
///
/// /// A servo with a delay, without Coulomb friction.
/// #[derive(Debug, Clone, Copy)]
/// struct AbDelay;
///
/// impl UnknownSet<3> for AbDelay {
///     const UNKNOWNS: [Unknown; 3] = [Unknown::A, Unknown::B, Unknown::Delay];
/// }
///
/// impl IdentifiableSet<3> for AbDelay {
///     type Lower<N: Number> = [N; 3];
///     type Inputs<N: Number> = DelayedInputs<N, 16>;
/// }
/// ```
pub trait IdentifiableSet<const P: usize>: UnknownSet<P> {
    /// Room for the lower triangle of a P × P matrix without its diagonal: `[N; P (P − 1)/2]`.
    type Lower<N: Number>: Lower<N> + Send;

    /// The inputs known besides the present command. `()` is for models without terms, [`DelayedInputs`] for a delay or
    /// dead band, [`AngledInputs`] for an angle.
    type Inputs<N: Number>: KnownInputs<N> + Send;
}

macro_rules! without_terms {
    ($($set:ty, $count:literal, $lower:literal;)*) => {$(
        impl IdentifiableSet<$count> for $set {
            type Lower<N: Number> = [N; $lower];
            type Inputs<N: Number> = ();
        }
    )*};
}

without_terms! {
    Unknowns<2>, 2, 1;
    Unknowns<3>, 3, 3;
    AbLoad, 3, 3;
    Unknowns<4>, 4, 6;
}

impl IdentifiableSet<AB_COULOMB_DELAY_LOAD> for Unknowns<AB_COULOMB_DELAY_LOAD> {
    type Lower<N: Number> = [N; 10];
    type Inputs<N: Number> = DelayedInputs<N, 8>;
}

impl IdentifiableSet<{ Unknown::COUNT }> for AllUnknowns {
    type Lower<N: Number> = [N; Unknown::COUNT * (Unknown::COUNT - 1) / 2];
    type Inputs<N: Number> = AngledInputs<N, 128>;
}
