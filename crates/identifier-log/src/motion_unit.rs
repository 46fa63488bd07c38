//! The unit of the positions of a result. What is physical takes an [`AxisKind`], which exists only where that unit is
//! stated.

use identifier_core::parameters::{Quantity, Unknown};
use serde::{Serialize, Serializer};

/// An axis whose unit of position is stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisKind {
    /// Positions in rad.
    Rotary,
    /// Positions in m.
    Linear,
}

/// The unit of the positions of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionUnit {
    /// rad or m.
    Stated(AxisKind),
    /// Counts of an encoder of which nobody stated how many make a revolution.
    Count,
    /// The unit of the position's column, which nobody stated.
    Own,
    /// The unit of a column of velocity, which nobody stated, times s.
    OwnVelocity,
}

/// Nobody stated the unit of a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the position is in {}, and nobody stated the size of one: identify with --counts-per-rev N if it counts an encoder, \
     else with --position-unit UNIT and perhaps --position-scale",
    .0.name()
)]
pub struct UnstatedUnit(MotionUnit);

impl MotionUnit {
    const ALL: [Self; 5] = [
        Self::Stated(AxisKind::Rotary),
        Self::Stated(AxisKind::Linear),
        Self::Count,
        Self::Own,
        Self::OwnVelocity,
    ];

    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stated(AxisKind::Rotary) => "rad",
            Self::Stated(AxisKind::Linear) => "m",
            Self::Count => "counts",
            Self::Own => "own units",
            Self::OwnVelocity => "own units·s",
        }
    }

    /// That of a name in results.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name() == name)
    }

    /// The unit of an unknown.
    #[must_use]
    pub const fn of(self, unknown: Unknown) -> &'static str {
        let [gain, acceleration] = match self {
            Self::Stated(AxisKind::Rotary) => return unknown.unit(),
            Self::Stated(AxisKind::Linear) => ["m/s² per command unit", "m/s²"],
            Self::Count => ["counts/s² per command unit", "counts/s²"],
            Self::Own => ["own units/s² per command unit", "own units/s²"],
            Self::OwnVelocity => ["own units/s per command unit", "own units/s"],
        };
        match unknown.quantity() {
            Quantity::Gain => gain,
            Quantity::Acceleration => acceleration,
            _ => unknown.unit(),
        }
    }

    /// The axis.
    ///
    /// # Errors
    /// Nobody stated the unit.
    pub const fn axis(self) -> Result<AxisKind, UnstatedUnit> {
        match self {
            Self::Stated(axis) => Ok(axis),
            _ => Err(UnstatedUnit(self)),
        }
    }
}

impl Serialize for MotionUnit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
