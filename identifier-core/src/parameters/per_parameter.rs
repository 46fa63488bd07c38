use super::{Parameter, ParameterSet};
use crate::unrolled::each;

/// A value for each of the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PerParameter<T> {
    /// For a.
    pub a: T,
    /// For b.
    pub b: T,
    /// For Coulomb friction.
    pub coulomb: T,
    /// For the load.
    pub load: T,
}

impl<T: Copy> PerParameter<T> {
    /// The value for a parameter.
    #[must_use]
    pub fn get(&self, parameter: Parameter) -> T {
        match parameter {
            Parameter::A => self.a,
            Parameter::B => self.b,
            Parameter::Coulomb => self.coulomb,
            Parameter::Load => self.load,
        }
    }

    /// The same for each parameter.
    #[inline]
    #[must_use]
    pub const fn all(value: T) -> Self {
        Self {
            a: value,
            b: value,
            coulomb: value,
            load: value,
        }
    }

    /// Those of a set; `none` for a parameter that it does not have.
    #[inline]
    #[must_use]
    pub(crate) fn of_set<S: ParameterSet<P>, const P: usize>(values: &[T; P], none: T) -> Self {
        let mut all = Self::all(none);
        each::<P>(|i| match S::PARAMETERS[i] {
            Parameter::A => all.a = values[i],
            Parameter::B => all.b = values[i],
            Parameter::Coulomb => all.coulomb = values[i],
            Parameter::Load => all.load = values[i],
        });
        all
    }

    /// One for each parameter.
    #[must_use]
    pub fn from_fn(mut of: impl FnMut(Parameter) -> T) -> Self {
        Self {
            a: of(Parameter::A),
            b: of(Parameter::B),
            coulomb: of(Parameter::Coulomb),
            load: of(Parameter::Load),
        }
    }
}
