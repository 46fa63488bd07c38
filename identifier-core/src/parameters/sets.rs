use super::unknowns::Changed;
use super::{Parameter, Terms, Unknown};
use crate::constants::fingerprint;

/// Unknowns of a model by their number: [`AB`], [`AB_COULOMB`], [`AB_COULOMB_LOAD`] or [`AB_COULOMB_DELAY_LOAD`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unknowns<const P: usize>;

/// The unknowns a and b.
pub const AB: usize = 2;

/// The unknowns a, b and Coulomb friction.
pub const AB_COULOMB: usize = 3;

/// The unknowns a, b, Coulomb friction and load.
pub const AB_COULOMB_LOAD: usize = 4;

/// The unknowns a, b, Coulomb friction, delay and load.
pub const AB_COULOMB_DELAY_LOAD: usize = 5;

/// [a, b, load].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AbLoad;

/// The P unknowns of a model, optional terms included, as a type. So a term that a model does not have costs nothing.
///
/// A set begins with a and b, and the load, if it is one of them, comes last.
pub trait UnknownSet<const P: usize>: Copy + core::fmt::Debug {
    /// The unknowns, in their order.
    const UNKNOWNS: [Unknown; P];

    /// Coulomb friction is one of them.
    const HAS_COULOMB: bool = has(&Self::UNKNOWNS, Unknown::Coulomb);
    /// A term changes friction with the speed.
    const HAS_SPEED_TERMS: bool = changes(&Self::UNKNOWNS, Changed::ViscousFriction)
        || changes(&Self::UNKNOWNS, Changed::CoulombFriction);
    /// A term changes Coulomb friction.
    const HAS_COULOMB_TERMS: bool = changes(&Self::UNKNOWNS, Changed::CoulombFriction);
    /// A term changes the load.
    const HAS_LOAD_TERMS: bool = changes(&Self::UNKNOWNS, Changed::Load);
    /// The optional terms whose sizes are among them.
    const TERMS: Terms = terms(&Self::UNKNOWNS);
    /// There is an optional term.
    const HAS_TERMS: bool = !Self::TERMS.is_empty();
}

/// A set without optional terms: the P parameters of a model.
///
/// Every model has a and b; Coulomb friction and load are zero in a model without them. A known parameter of the model
/// is *frozen* in the configuration of its estimator.
pub trait ParameterSet<const P: usize>: UnknownSet<P> {
    /// The parameters, in their order.
    const PARAMETERS: [Parameter; P] = parameters(&Self::UNKNOWNS);
}

const fn parameters<const P: usize>(unknowns: &[Unknown; P]) -> [Parameter; P] {
    let mut parameters = [Parameter::A; P];
    let mut i = 0;
    while i < P {
        parameters[i] = match unknowns[i].parameter() {
            Some(parameter) => parameter,
            None => panic!("a set of parameters has no optional term"),
        };
        i += 1;
    }
    parameters
}

const fn has(unknowns: &[Unknown], wanted: Unknown) -> bool {
    let mut i = 0;
    while i < unknowns.len() {
        if unknowns[i] as u8 == wanted as u8 {
            return true;
        }
        i += 1;
    }
    false
}

const fn changes(unknowns: &[Unknown], part: Changed) -> bool {
    let mut i = 0;
    while i < unknowns.len() {
        if let Some(changed) = unknowns[i].changes()
            && changed as u8 == part as u8
        {
            return true;
        }
        i += 1;
    }
    false
}

const fn terms(unknowns: &[Unknown]) -> Terms {
    let mut terms = Terms::NONE;
    let mut i = 0;
    while i < unknowns.len() {
        if let Some(term) = unknowns[i].term() {
            terms = terms.with(term);
        }
        i += 1;
    }
    terms
}

/// Every unknown, for a PC or a large chip: the unwanted ones are left out at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AllUnknowns;

macro_rules! unknown_sets {
    ($($set:ty, $count:tt: [$($unknown:ident),*];)*) => {$(
        impl UnknownSet<$count> for $set {
            const UNKNOWNS: [Unknown; $count] = [$(Unknown::$unknown),*];
        }
    )*};
}

unknown_sets! {
    Unknowns<AB>, AB: [A, B];
    Unknowns<AB_COULOMB>, AB_COULOMB: [A, B, Coulomb];
    AbLoad, 3: [A, B, Load];
    Unknowns<AB_COULOMB_LOAD>, AB_COULOMB_LOAD: [A, B, Coulomb, Load];
    Unknowns<AB_COULOMB_DELAY_LOAD>, AB_COULOMB_DELAY_LOAD: [A, B, Coulomb, Delay, Load];
}

impl ParameterSet<AB> for Unknowns<AB> {}
impl ParameterSet<AB_COULOMB> for Unknowns<AB_COULOMB> {}
impl ParameterSet<3> for AbLoad {}
impl ParameterSet<AB_COULOMB_LOAD> for Unknowns<AB_COULOMB_LOAD> {}

impl UnknownSet<{ Unknown::COUNT }> for AllUnknowns {
    const UNKNOWNS: [Unknown; Unknown::COUNT] = Unknown::ALL;
}

/// The same of a set of unknowns and another size of the type.
pub(crate) const fn unknowns_fingerprint(unknowns: &[Unknown], size: usize) -> u32 {
    let mut found = size as u32;
    let mut i = 0;
    while i < unknowns.len() {
        found = fingerprint(unknowns[i].name(), &[found]);
        i += 1;
    }
    found
}
