//! The unknowns of the servo: its four parameters and the sizes of optional effects. Also their values, their units,
//! and the sets of them that models have.

mod identified_servo;
mod model_parameters;
mod per_parameter;
pub(crate) mod sets;
mod terms;
mod tolerance;
mod unknowns;

pub use identified_servo::IdentifiedServo;
pub(crate) use model_parameters::ModelParameters;
pub use per_parameter::{PerParameter, ServoParameters};
pub(crate) use sets::unknowns_fingerprint;
pub use sets::{AbLoad, AllUnknowns, ParameterSet, UnknownSet, Unknowns};
pub use terms::Terms;
pub use tolerance::Tolerance;
pub(crate) use unknowns::UsualSizes;
pub use unknowns::{PerQuantity, Quantity, Term, Unknown};

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
    /// All parameters, in the order of a model that has them all.
    pub const ALL: [Self; 4] = [Self::A, Self::B, Self::Coulomb, Self::Load];

    const fn unknown(self) -> Unknown {
        match self {
            Self::A => Unknown::A,
            Self::B => Unknown::B,
            Self::Coulomb => Unknown::Coulomb,
            Self::Load => Unknown::Load,
        }
    }

    /// Its name in configurations and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.unknown().name()
    }

    /// Machine units per SI unit: T for a, T²/ρ for the others.
    #[must_use]
    pub fn scale(self, units: &Units) -> f64 {
        self.unknown().scale(units)
    }
}
