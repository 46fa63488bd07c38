use super::super::{CommissionError, Limits};

/// Settings of a probing motion, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ProbingSettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of a count, rad.
    pub resolution: f64,
    /// Limits of the axis.
    pub limits: Limits,
    /// The largest b that the servo may have, rad/s² per command unit, if it is stated.
    pub max_gain: Option<f64>,
    /// The known part of the delay from the reading of the encoder to the change of the output, s.
    pub command_delay: f64,
}

impl ProbingSettings {
    /// The least travel to either side, counts.
    pub(crate) const MIN_TRAVEL_COUNTS: f64 = 16.0;

    /// The least speed, counts per second.
    pub(crate) const MIN_SPEED_COUNTS: f64 = 200.0;

    /// The part of the speed limit by which all of the command may change the speed in a sample.
    pub(crate) const MAX_SPEED_CHANGE: f64 = 0.15;

    /// # Errors
    /// Limits that contradict themselves or are too small for evidence with this encoder. Also limits that the
    /// strongest servo could pass within a few samples.
    pub(crate) fn check(&self) -> Result<(), CommissionError> {
        let limits = &self.limits;
        limits.check()?;
        let [low, high] = limits.travel;
        let travel = high.min(-low);
        let needed = Self::MIN_TRAVEL_COUNTS * self.resolution;
        if travel < needed {
            return Err(CommissionError::TravelTooSmall { travel, needed });
        }
        let needed = Self::MIN_SPEED_COUNTS * self.resolution;
        if limits.speed < needed {
            return Err(CommissionError::SpeedTooSmall {
                speed: limits.speed,
                needed,
            });
        }
        self.check_strength()
    }

    /// # Errors
    /// [`CommissionError::TooStrong`].
    fn check_strength(&self) -> Result<(), CommissionError> {
        let Some(gain) = self.max_gain else {
            return Ok(());
        };
        let [least, most] = self.limits.command;
        let command = most.max(-least);
        let change = gain * command * self.sample_time;
        let allowed = Self::MAX_SPEED_CHANGE * self.limits.speed;
        if change <= allowed {
            return Ok(());
        }
        Err(CommissionError::TooStrong {
            sample_time: self.sample_time,
            most: self.sample_time * allowed / change,
            command: command * allowed / change,
        })
    }
}

/// The largest travel and speed of an unknown servo in the first motion, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestMotion {
    /// Lowest and highest position, rad from the servo's start.
    pub travel: [f64; 2],
    /// Rad/s.
    pub speed: f64,
    /// How far the strongest servo can go before a stuck encoder is found ([`LargestMotion::STUCK_ENCODER_TIME`]),
    /// rad. None if the largest b is not stated.
    pub unseen: Option<f64>,
}

impl LargestMotion {
    /// The longest time of ordered motion until a stuck encoder is found, s.
    pub const STUCK_ENCODER_TIME: f64 = 0.15;
}
