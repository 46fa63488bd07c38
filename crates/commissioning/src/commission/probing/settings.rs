use super::super::{CommissionError, CommissionSettings};

impl CommissionSettings {
    /// The least travel to either side, counts.
    const MIN_TRAVEL_COUNTS: f64 = 16.0;

    /// The least speed, counts per second.
    const MIN_SPEED_COUNTS: f64 = 200.0;

    /// The part of the speed limit by which all of the command may change the speed in a sample.
    const MAX_SPEED_CHANGE: f64 = 0.15;

    /// Bounds of the first motion.
    #[must_use]
    pub(in crate::commission) fn largest_motion(&self) -> LargestMotion {
        let limits = &self.limits;
        let [least, most] = limits.command;
        let (mut travel, mut speed) = (limits.travel, limits.speed);
        let acceleration = self.max_gain.map(|gain| gain * most.max(-least));
        let reached = |acceleration: f64, time: f64| 0.5 * acceleration * time * time;
        if let Some(acceleration) = acceleration {
            let reached = reached(acceleration, limits.duration);
            travel = travel.map(|end| end.clamp(-reached, reached));
            speed = speed.min(acceleration * limits.duration);
        }
        let time = LargestMotion::STUCK_ENCODER_TIME.min(limits.duration);
        LargestMotion {
            travel,
            speed,
            unseen: acceleration.map(|acceleration| reached(acceleration, time)),
        }
    }

    /// # Errors
    /// Limits that contradict themselves or are too small for evidence with this encoder. Also limits that the
    /// strongest servo could pass within a few samples.
    pub(super) fn check_motion(&self) -> Result<(), CommissionError> {
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
