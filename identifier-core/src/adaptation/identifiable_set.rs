use super::{Evidence, FirstOrder, OnDemand, ScoreTest, Whitening};
use crate::linalg::Lower;
use crate::model::{AngledInputs, DelayedInputs, KnownInputs};
use crate::number::Number;
use crate::parameters::{
    Ab, AbCoulomb, AbCoulombDelayLoad, AbCoulombLoad, AbLoad, AllUnknowns, Term, Unknown,
    UnknownSet,
};

/// A set of unknowns with the memory that identifying them takes, as types, so that a model without a
/// term keeps nothing for it.
///
/// A firmware may have a set of its own:
///
/// ```
/// use identifier_core::identifier::{IdentifiableSet, OnDemand};
/// use identifier_core::identifier::DelayedInputs;
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
///     type Evidence<N: Number> = OnDemand;
///     type Whitening<N: Number> = ();
/// }
/// ```
pub trait IdentifiableSet<const P: usize>: UnknownSet<P> {
    /// Room for the lower triangle of a P × P matrix without its diagonal: `[N; P (P − 1)/2]`.
    type Lower<N: Number>: Lower<N> + Send;

    /// The inputs known besides the present command: `()` for models without terms,
    /// [`DelayedInputs`] for those with a delay or dead band, [`AngledInputs`] for those with an angle.
    type Inputs<N: Number>: KnownInputs<N> + Send;

    /// Where evidence for terms is gathered: `()` for models without terms, [`OnDemand`] where a term
    /// enters when the settings demand it, `ScoreTest` where evidence decides.
    type Evidence<N: Number>: Evidence<N, P> + Send;

    /// The treatment of a load that wanders: `()` for none, `FirstOrder` for whitening.
    type Whitening<N: Number>: Whitening<N, P> + Send;

    /// A model with these unknowns can have a term.
    #[must_use]
    fn has_term<N: Number>(term: Term) -> bool {
        match term {
            Term::WanderingLoad => <Self::Whitening<N> as Whitening<N, P>>::WHITENS,
            _ => Self::TERMS.has(term),
        }
    }
}

macro_rules! without_terms {
    ($($set:ident, $count:literal, $lower:literal;)*) => {$(
        impl IdentifiableSet<$count> for $set {
            type Lower<N: Number> = [N; $lower];
            type Inputs<N: Number> = ();
            type Evidence<N: Number> = ();
            type Whitening<N: Number> = ();
        }
    )*};
}

without_terms! {
    Ab, 2, 1;
    AbCoulomb, 3, 3;
    AbLoad, 3, 3;
    AbCoulombLoad, 4, 6;
}

impl IdentifiableSet<5> for AbCoulombDelayLoad {
    type Lower<N: Number> = [N; 10];
    type Inputs<N: Number> = DelayedInputs<N, 8>;
    type Evidence<N: Number> = OnDemand;
    type Whitening<N: Number> = ();
}

impl IdentifiableSet<{ Unknown::COUNT }> for AllUnknowns {
    type Lower<N: Number> = [N; Unknown::COUNT * (Unknown::COUNT - 1) / 2];
    type Inputs<N: Number> = AngledInputs<N, 128>;
    type Evidence<N: Number> = ScoreTest<N, { Unknown::COUNT }>;
    type Whitening<N: Number> = FirstOrder<N, { Unknown::COUNT }>;
}
