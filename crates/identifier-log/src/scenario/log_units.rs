//! The units of a log's columns.

use std::f64::consts::TAU;

use super::names::named;

/// The units of a log's columns. A scale multiplies what its column holds, before its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogUnits {
    /// Of time.
    pub time: TimeUnit,
    /// For the position.
    pub position: PositionUnit,
    /// Scale of the position, log units per log unit; below 0 for the other direction.
    pub position_scale: f64,
    /// Unit of the reference; none for that of the position, its scale included.
    pub reference: Option<PositionUnit>,
    /// For the reference.
    pub reference_scale: f64,
    /// Command units for one of the log's.
    pub command_scale: f64,
    /// Torque of a unit of command, N·m (N on a linear axis), where it is declared.
    pub torque_constant: Option<f64>,
    /// Counts of a revolution, where an encoder is declared.
    pub counts_per_rev: Option<f64>,
}

named! {
    /// A unit of time.
    pub enum TimeUnit {
        /// Seconds.
        Second = "s",
        /// Milliseconds.
        Millisecond = "ms",
        /// Microseconds.
        Microsecond = "us",
        /// Nanoseconds.
        Nanosecond = "ns",
        /// Minutes.
        Minute = "min",
        /// Hours.
        Hour = "h",
        /// Time stamps by calendar and clock.
        Stamp = "iso-8601",
        /// Samples: a counter.
        Sample = "samples",
    }
}

named! {
    /// A unit of position.
    pub enum PositionUnit {
        /// Radians.
        Radian = "rad",
        /// Degrees.
        Degree = "deg",
        /// Turns.
        Turn = "turns",
        /// Counts of the declared encoder, or of one that is not known.
        Count = "counts",
        /// Metres of a linear axis, for which m is read for rad everywhere.
        Metre = "m",
        /// Millimetres of a linear axis.
        Millimetre = "mm",
        /// The unit of the column, which nobody stated.
        Own = "own",
    }
}

impl TimeUnit {
    /// Its length, s, that of a time stamp once it is read; none of a counter of samples.
    #[must_use]
    pub const fn seconds(self) -> Option<f64> {
        match self {
            Self::Second | Self::Stamp => Some(1.0),
            Self::Millisecond => Some(1e-3),
            Self::Microsecond => Some(1e-6),
            Self::Nanosecond => Some(1e-9),
            Self::Minute => Some(60.0),
            Self::Hour => Some(3600.0),
            Self::Sample => None,
        }
    }
}

impl LogUnits {
    /// rad, s and command units.
    pub const SI: Self = Self {
        time: TimeUnit::Second,
        position: PositionUnit::Radian,
        position_scale: 1.0,
        reference: None,
        reference_scale: 1.0,
        command_scale: 1.0,
        torque_constant: None,
        counts_per_rev: None,
    };

    /// SI units for one of a column's, and command units for a torque. A sample lasts `sample_time`, s.
    #[must_use]
    pub fn scale(&self, quantity: LogQuantity, sample_time: f64) -> f64 {
        match quantity {
            LogQuantity::Time => self.time.seconds().unwrap_or(sample_time),
            LogQuantity::Reference => self.reference(),
            LogQuantity::Position | LogQuantity::Velocity => self.position(),
            LogQuantity::Command => self.command_scale,
            LogQuantity::KnownTorque => self.torque_constant.map_or(f64::NAN, f64::recip),
        }
    }

    /// Radians (or metres) for one of the position column's units.
    fn position(&self) -> f64 {
        self.position_scale * self.radians(self.position)
    }

    /// Radians (or metres) for one of the reference column's units.
    fn reference(&self) -> f64 {
        let unit = self.reference.map(|unit| self.radians(unit));
        self.reference_scale * unit.unwrap_or_else(|| self.position())
    }

    /// Radians (or metres) for one of a unit; 1 where that is not stated, as of counts of no encoder.
    #[must_use]
    pub fn radians(&self, unit: PositionUnit) -> f64 {
        match unit {
            PositionUnit::Radian | PositionUnit::Metre | PositionUnit::Own => 1.0,
            PositionUnit::Degree => TAU / 360.0,
            PositionUnit::Turn => TAU,
            PositionUnit::Count => self.counts_per_rev.map_or(1.0, |counts| TAU / counts),
            PositionUnit::Millimetre => 1e-3,
        }
    }
}

/// The quantity in a column of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(
    missing_docs,
    reason = "each is documented at its column in LogSettings"
)]
pub enum LogQuantity {
    Time,
    Reference,
    Position,
    Command,
    KnownTorque,
    Velocity,
}

impl LogQuantity {
    /// The key that states its column.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Time => "log.time",
            Self::Reference => "log.reference",
            Self::Position => "log.position",
            Self::Command => "log.command",
            Self::KnownTorque => "log.known_torque",
            Self::Velocity => "log.velocity",
        }
    }
}
