use super::{ParameterSet, PerParameter, PerQuantity, ServoParameters};
use crate::number::{Arithmetic, Number};
use crate::units::Units;

/// The parameters of the model in machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelParameters<N: Arithmetic> {
    /// â T.
    pub x: N::Factor,
    /// b̂ T²/ρ.
    pub gain: N,
    /// ĉ T²/ρ.
    pub coulomb: N,
    /// d̂ T²/ρ, the part that is a parameter of its own.
    pub load: N,
}

impl<N: Arithmetic> ModelParameters<N> {
    /// The model of a parameter set with these values.
    #[inline]
    pub(crate) fn from_values<S: ParameterSet<P>, const P: usize>(values: &[N; P]) -> Self {
        let values = PerParameter::of_set::<S, P>(values, N::ZERO);
        Self {
            x: values.a.as_factor(),
            gain: values.b,
            coulomb: values.coulomb,
            load: values.load,
        }
    }
}

impl<N: Number> ModelParameters<N> {
    /// The parameters by name.
    #[inline]
    pub(crate) fn per_parameter(self) -> PerParameter<N> {
        PerParameter::new(self.x, self.gain, self.coulomb, self.load)
    }

    /// The parameters in SI.
    #[inline]
    pub(crate) fn to_si(self, units: &Units) -> ServoParameters {
        let machine = PerQuantity::machine(units);
        ServoParameters::new(
            self.x.to_f64() / machine.rate,
            self.gain.to_f64() / machine.gain,
            self.coulomb.to_f64() / machine.acceleration,
            self.load.to_f64() / machine.acceleration,
        )
    }
}
