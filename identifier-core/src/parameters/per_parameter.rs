use super::{Parameter, ParameterSet};
use crate::unrolled::each;

/// A value for each of the parameters, laid out as C does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct PerParameter<T> {
    /// For a = f/J, viscous friction over inertia.
    pub a: T,
    /// For b = k/J, gain over inertia.
    pub b: T,
    /// For c, Coulomb friction over inertia.
    pub coulomb: T,
    /// For d = p/J, constant disturbance over inertia.
    pub load: T,
}

/// The parameters of a servo q̈ = −a q̇ + b u + d − c sign(q̇), (2) with Coulomb friction added: a in 1/s, b in rad/s²
/// per command unit, c and d in rad/s².
pub type ServoParameters = PerParameter<f64>;

impl ServoParameters {
    /// The servo with a further load, given as the command that balances it: b times `command` is
    /// added.
    #[must_use]
    pub fn with_load_of(self, command: f64) -> Self {
        Self {
            load: self.load + self.b * command,
            ..self
        }
    }
}

impl<T> PerParameter<T> {
    /// One for each parameter, in the order of [`Parameter::ALL`].
    #[inline]
    #[must_use]
    pub const fn new(a: T, b: T, coulomb: T, load: T) -> Self {
        Self {
            a,
            b,
            coulomb,
            load,
        }
    }
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
        Self::new(value, value, value, value)
    }

    /// Those of a set; `none` for a parameter that it does not have.
    #[inline]
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
    pub fn from_fn(of: impl FnMut(Parameter) -> T) -> Self {
        let [a, b, coulomb, load] = Parameter::ALL.map(of);
        Self::new(a, b, coulomb, load)
    }
}
