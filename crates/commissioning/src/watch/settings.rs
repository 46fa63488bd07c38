use identifier_core::error::{Allowed, OutOfRange};
#[cfg(test)]
use identifier_core::reason::Reason;
use identifier_core::units::Units;

/// Limits of an axis, known before the servo is identified, SI. For a linear axis read m for rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchSettings {
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
    /// The use of the axis meanwhile.
    pub used_for: Use,
}

/// The use of an axis, by which its motion may differ from that of its model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// A commissioning: nothing but its command moves the axis, and a load steps once in a while.
    Commissioning,
    /// Operation: loads act at any time, and inertia changes with what the axis carries.
    Operation,
}

impl Use {
    /// Largest ratio of b in operation to the identified b, or of the identified to that in operation.
    const INERTIA_RANGE: f64 = 2.5;

    /// The factor by which b may exceed that of its model, or be below it.
    pub(super) fn gain_range(self) -> f64 {
        match self {
            Self::Commissioning => 1.0,
            Self::Operation => Self::INERTIA_RANGE,
        }
    }
}

impl WatchSettings {
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

/// A sample as the watch sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Observation<N> {
    /// Counts that the encoder has moved since its last valid reading; none if there is no valid one now.
    pub increment: Option<N>,
    /// The command that acted since the last sample, command units.
    pub command: N,
    /// Counts from the start; the last one known if there is no valid reading.
    pub position: N,
    /// The setpoint of the controller, counts from the start. None while no controller acts: the stage is disabled,
    /// or a ramp or a relay gives the command.
    pub setpoint: Option<N>,
    /// True if the sample before ended too late.
    pub late: bool,
    /// True if the command that acted must move the servo in spite of friction: that of a relay after a ramp has
    /// found the break-away.
    pub must_move: bool,
    /// True if a signal excites dynamics that a model of one mass does not have. An unexpected motion is then a fault
    /// only if the servo does not follow its setpoint either.
    pub excited: bool,
}

/// Samples from the one in which a fault begins to show until it is found.
#[cfg(test)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DetectionTimes {
    /// Samples running that are late.
    pub overrun: u32,
    /// Samples running without a reading.
    pub encoder_lost: u32,
    /// Counts from which on a jump is found in the sample in which it happens.
    pub smallest_jump: f64,
    /// Samples with a speed of 1.25 times the allowed one, and three counts in the time that a speed is
    /// the mean of.
    pub speed: u32,
    /// Samples at standstill under a command that must move the servo.
    pub standing: u32,
    /// Samples of motion in which the command changes enough.
    pub response: u32,
    /// Half-cycles of an oscillation,
    pub half_cycles: u32,
    /// none longer than this many samples.
    pub longest_half_cycle: u32,
}

#[cfg(test)]
impl DetectionTimes {
    /// Samples within which a reason is found; none for one that the watch does not find.
    #[must_use]
    pub(crate) fn samples(&self, reason: Reason) -> Option<u32> {
        Some(match reason {
            Reason::Overrun => self.overrun,
            Reason::EncoderLost => self.encoder_lost,
            Reason::EncoderJumped | Reason::TravelLeft => 1,
            Reason::SpeedExceeded => self.speed,
            // A servo whose actuator dies comes to rest first.
            Reason::EncoderStuck | Reason::ActuatorDead => self.standing + self.response,
            Reason::ActuatorWeak | Reason::Reversed => self.response,
            Reason::Oscillating => self.half_cycles * self.longest_half_cycle,
            _ => return None,
        })
    }
}
