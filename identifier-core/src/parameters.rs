//! The parameters of the servo, and which of them a model has.

use crate::model::ServoParameters;
use crate::number::Number;
use crate::units::Units;

/// A parameter of the servo q̈ = −a q̇ + b u + d − c sign(q̇).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// a, viscous friction over inertia, 1/s.
    A,
    /// b, gain over inertia, rad/s² per command unit.
    B,
    /// c, Coulomb friction over inertia, rad/s².
    Coulomb,
    /// d, constant load over inertia, rad/s².
    Load,
}

impl Parameter {
    /// Its name in configurations and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::B => "b",
            Self::Coulomb => "coulomb",
            Self::Load => "load",
        }
    }

    /// Machine units per SI unit: T for a, T²/ρ for the others.
    #[must_use]
    pub fn scale(self, units: &Units) -> f64 {
        match self {
            Self::A => units.rate(),
            Self::B | Self::Coulomb | Self::Load => units.acceleration(),
        }
    }

    /// Its value in a servo.
    #[must_use]
    pub fn of(self, servo: &ServoParameters) -> f64 {
        match self {
            Self::A => servo.a,
            Self::B => servo.b,
            Self::Coulomb => servo.coulomb,
            Self::Load => servo.load,
        }
    }
}

/// The P parameters of a model, as a type, so that a model without friction costs nothing for it.
///
/// Every model has a and b; Coulomb friction and load are zero in a model without them. A parameter
/// that is in the model but known is *frozen* in the configuration of its law.
pub trait ParameterSet<const P: usize>: Copy + core::fmt::Debug {
    /// The parameters, in their order.
    const PARAMETERS: [Parameter; P];

    /// Whether Coulomb friction is one of them.
    const HAS_COULOMB: bool;
}

/// [a, b].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ab;

/// [a, b, coulomb].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AbCoulomb;

/// [a, b, load].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AbLoad;

/// [a, b, coulomb, load].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AbCoulombLoad;

impl ParameterSet<2> for Ab {
    const PARAMETERS: [Parameter; 2] = [Parameter::A, Parameter::B];
    const HAS_COULOMB: bool = false;
}

impl ParameterSet<3> for AbCoulomb {
    const PARAMETERS: [Parameter; 3] = [Parameter::A, Parameter::B, Parameter::Coulomb];
    const HAS_COULOMB: bool = true;
}

impl ParameterSet<3> for AbLoad {
    const PARAMETERS: [Parameter; 3] = [Parameter::A, Parameter::B, Parameter::Load];
    const HAS_COULOMB: bool = false;
}

impl ParameterSet<4> for AbCoulombLoad {
    const PARAMETERS: [Parameter; 4] = [
        Parameter::A,
        Parameter::B,
        Parameter::Coulomb,
        Parameter::Load,
    ];
    const HAS_COULOMB: bool = true;
}

/// The parameters of the model in machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelParameters<N> {
    /// â T.
    pub x: N,
    /// b̂ T²/ρ.
    pub gain: N,
    /// ĉ T²/ρ.
    pub coulomb: N,
    /// d̂ T²/ρ, the part that is a parameter of its own.
    pub load: N,
}

impl<N: Number> ModelParameters<N> {
    /// The model of a parameter set with these values.
    #[inline]
    #[must_use]
    pub fn from_values<S: ParameterSet<P>, const P: usize>(values: &[N; P]) -> Self {
        let mut model = Self {
            x: N::ZERO,
            gain: N::ZERO,
            coulomb: N::ZERO,
            load: N::ZERO,
        };
        for (parameter, &value) in S::PARAMETERS.iter().zip(values) {
            match parameter {
                Parameter::A => model.x = value,
                Parameter::B => model.gain = value,
                Parameter::Coulomb => model.coulomb = value,
                Parameter::Load => model.load = value,
            }
        }
        model
    }

    /// The parameters in SI.
    #[must_use]
    pub fn to_si(&self, units: &Units) -> ServoParameters {
        let si = |value: N, parameter: Parameter| value.to_f64() / parameter.scale(units);
        ServoParameters {
            a: si(self.x, Parameter::A),
            b: si(self.gain, Parameter::B),
            coulomb: si(self.coulomb, Parameter::Coulomb),
            load: si(self.load, Parameter::Load),
        }
    }
}
