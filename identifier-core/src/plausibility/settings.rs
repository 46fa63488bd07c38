use crate::error::{Allowed, OutOfRange};
use crate::units::Units;

/// What is known of a servo before it is identified, SI. For a linear axis read m for rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlausibilitySettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of a count, rad.
    pub resolution: f64,
    /// Lowest and highest position, rad from the start; infinite where there is no end.
    pub travel: [f64; 2],
    /// The largest speed, rad/s; infinite for none.
    pub speed: f64,
    /// Lowest and highest command, command units.
    pub command: [f64; 2],
}

impl PlausibilitySettings {
    /// # Errors
    /// The setting that is not allowed, by name.
    pub(super) fn check(&self) -> Result<Units, OutOfRange> {
        let units = Units::new(self.sample_time, self.resolution)?;
        let [low, high] = self.travel;
        if low != f64::NEG_INFINITY {
            Allowed::AtMost(0.0).check("travel", low)?;
        }
        if high != f64::INFINITY {
            Allowed::AtLeast(0.0).check("travel", high)?;
        }
        if self.speed != f64::INFINITY {
            Allowed::Above(0.0).check("speed", self.speed)?;
        }
        let [least, most] = self.command;
        Allowed::Below(0.0).check("command", least)?;
        Allowed::Above(0.0).check("command", most)?;
        Ok(units)
    }

    /// Half of the range of the command, command units.
    pub(super) fn limit(&self) -> f64 {
        let [least, most] = self.command;
        (most - least) / 2.0
    }
}
