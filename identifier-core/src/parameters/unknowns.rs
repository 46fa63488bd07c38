//! The unknowns of a model with optional terms, and which of them a model has.
//!
//! q̈ = −a q̇ − δa |q̇| + b D(u(t − τ)) + d − (c + s exp(−(q̇/v_s)²)) sign q̇ + g_s sin q + g_c cos q
//! + r_s sin Nq + r_c cos Nq,
//!
//! D being the dead band of the bridge. A model has the unknowns of its [`UnknownSet`](super::UnknownSet);
//! a term that is not among them costs nothing.

use super::Parameter;
use crate::units::Units;

/// An unknown of a model: one of the four parameters, or the size of an optional term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unknown {
    /// a, viscous friction over inertia, 1/s.
    A,
    /// b, gain over inertia, rad/s² per command unit.
    B,
    /// c, Coulomb friction over inertia, rad/s².
    Coulomb,
    /// τ, the total delay from command to acceleration, s.
    Delay,
    /// δa, the half difference of viscous friction forwards and backwards, over inertia, 1/s.
    Asymmetry,
    /// s, friction over inertia that fades with speed as exp(−(q̇/v_s)²), rad/s².
    LowSpeed,
    /// g_s, gravity over inertia that goes with sin q, rad/s².
    GravitySine,
    /// g_c, gravity over inertia that goes with cos q, rad/s².
    GravityCosine,
    /// r_s, ripple over inertia that goes with sin Nq, rad/s².
    RippleSine,
    /// r_c, ripple over inertia that goes with cos Nq, rad/s².
    RippleCosine,
    /// δ, the dead band of the bridge to either side, command units.
    DeadBand,
    /// d, constant load over inertia, rad/s².
    Load,
}

impl Unknown {
    /// All unknowns, in the order of a model that has them all.
    pub const ALL: [Self; 12] = [
        Self::A,
        Self::B,
        Self::Coulomb,
        Self::Delay,
        Self::Asymmetry,
        Self::LowSpeed,
        Self::GravitySine,
        Self::GravityCosine,
        Self::RippleSine,
        Self::RippleCosine,
        Self::DeadBand,
        Self::Load,
    ];

    /// The parameter that it is; none for the size of a term.
    #[must_use]
    pub const fn parameter(self) -> Option<Parameter> {
        match self {
            Self::A => Some(Parameter::A),
            Self::B => Some(Parameter::B),
            Self::Coulomb => Some(Parameter::Coulomb),
            Self::Load => Some(Parameter::Load),
            _ => None,
        }
    }

    /// The term whose size it is; none for a parameter.
    #[must_use]
    pub const fn term(self) -> Option<Term> {
        match self {
            Self::A | Self::B | Self::Coulomb | Self::Load => None,
            Self::Delay => Some(Term::Delay),
            Self::Asymmetry => Some(Term::Asymmetry),
            Self::LowSpeed => Some(Term::LowSpeed),
            Self::GravitySine | Self::GravityCosine => Some(Term::Gravity),
            Self::RippleSine | Self::RippleCosine => Some(Term::Ripple),
            Self::DeadBand => Some(Term::DeadBand),
        }
    }

    /// Its name in configurations and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::B => "b",
            Self::Coulomb => "coulomb",
            Self::Delay => "delay",
            Self::Asymmetry => "asymmetry",
            Self::LowSpeed => "low-speed",
            Self::GravitySine => "gravity-sine",
            Self::GravityCosine => "gravity-cosine",
            Self::RippleSine => "ripple-sine",
            Self::RippleCosine => "ripple-cosine",
            Self::DeadBand => "dead-band",
            Self::Load => "load",
        }
    }

    /// Its unit.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::A | Self::Asymmetry => "1/s",
            Self::B => "rad/s² per command unit",
            Self::Delay => "s",
            Self::DeadBand => "command units",
            _ => "rad/s²",
        }
    }

    /// Machine units per SI unit.
    #[must_use]
    pub fn scale(self, units: &Units) -> f64 {
        match self {
            Self::A | Self::Asymmetry => units.rate(),
            Self::Delay => 1.0 / units.sample_time(),
            Self::DeadBand => 1.0,
            _ => units.acceleration(),
        }
    }
}

impl From<Parameter> for Unknown {
    fn from(parameter: Parameter) -> Self {
        match parameter {
            Parameter::A => Self::A,
            Parameter::B => Self::B,
            Parameter::Coulomb => Self::Coulomb,
            Parameter::Load => Self::Load,
        }
    }
}

/// An optional term of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Term {
    /// Total delay of the command.
    Delay,
    /// Viscous friction that differs with the direction.
    Asymmetry,
    /// Friction that changes at low speed.
    LowSpeed,
    /// Gravity on an absolute angle.
    Gravity,
    /// Ripple of a declared order.
    Ripple,
    /// Dead band of the bridge.
    DeadBand,
    /// A load that wanders. It has no size: errors that go on from block to block are no longer taken
    /// for news of the parameters.
    WanderingLoad,
}

impl Term {
    /// All terms, in the order in which they enter where several are demanded.
    pub const ALL: [Self; 7] = [
        Self::Delay,
        Self::Gravity,
        Self::Asymmetry,
        Self::DeadBand,
        Self::LowSpeed,
        Self::Ripple,
        Self::WanderingLoad,
    ];

    /// Its name in configurations and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::Asymmetry => "asymmetry",
            Self::LowSpeed => "low-speed",
            Self::Gravity => "gravity",
            Self::Ripple => "ripple",
            Self::DeadBand => "dead-band",
            Self::WanderingLoad => "wandering-load",
        }
    }

    /// Whether an unknown is one of its sizes.
    pub(crate) fn is_of(self, unknown: Unknown) -> bool {
        unknown.term() == Some(self)
    }

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// Some of the terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Terms(u8);

impl Terms {
    /// None of them.
    pub const NONE: Self = Self(0);

    /// These and a term.
    #[must_use]
    pub const fn with(self, term: Term) -> Self {
        Self(self.0 | term.bit())
    }

    /// Whether a term is one of them.
    #[must_use]
    pub const fn has(self, term: Term) -> bool {
        self.0 & term.bit() != 0
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those in one or the other.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
