use crate::units::Units;

/// The kind of quantity that an unknown is. Its unit, its scales and the size of a usual value all follow
/// from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Of a motion that decays, 1/s.
    Rate,
    /// Acceleration per command, rad/s² per command unit.
    Gain,
    /// A force over inertia, rad/s².
    Acceleration,
    /// Time, s.
    Time,
    /// Command, command units.
    Command,
}

/// A value for each kind of quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerQuantity<T> {
    /// For a rate.
    pub rate: T,
    /// For a gain.
    pub gain: T,
    /// For an acceleration.
    pub acceleration: T,
    /// For a time.
    pub time: T,
    /// For a command.
    pub command: T,
}

impl Quantity {
    /// Its unit.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Rate => "1/s",
            Self::Gain => "rad/s² per command unit",
            Self::Acceleration => "rad/s²",
            Self::Time => "s",
            Self::Command => "command units",
        }
    }
}

impl<T: Copy> PerQuantity<T> {
    /// The value for a kind of quantity.
    #[inline]
    #[must_use]
    pub fn of(&self, quantity: Quantity) -> T {
        match quantity {
            Quantity::Rate => self.rate,
            Quantity::Gain => self.gain,
            Quantity::Acceleration => self.acceleration,
            Quantity::Time => self.time,
            Quantity::Command => self.command,
        }
    }
}

impl PerQuantity<f64> {
    /// Machine units per SI unit.
    pub(super) fn machine(units: &Units) -> Self {
        Self {
            rate: units.rate(),
            gain: units.acceleration(),
            acceleration: units.acceleration(),
            time: 1.0 / units.sample_time(),
            command: 1.0,
        }
    }

    /// Units of a block of `samples` per unit of a sample.
    pub(crate) fn block(samples: f64) -> Self {
        Self {
            rate: samples,
            gain: samples * samples,
            acceleration: samples * samples,
            time: 1.0 / samples,
            command: 1.0,
        }
    }
}
